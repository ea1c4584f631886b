//! People in rows who walk against the x axis and stop for robots ahead of them: the twin of examples/walkers.py.
use std::f64::consts::PI;

use crowdcosim_examples::cdr::{Reader, Writer};
use crowdcosim_examples::node::{check_options, run, Component, Inputs, Port};
use serde_json::Value;

const ROWS: usize = 9;
const STRIDE: f64 = 1.4;
const MAX_ACCELERATION: f64 = 2.0;

struct Person {
    x: f64,
    y: f64,
    speed: f64,
    phase: f64,
}

#[derive(Default)]
struct Walkers {
    count: usize,
    speed: f64,
    width: f64,
    depth: f64,
    period: i64,
    people: Vec<Person>,
}

impl Walkers {
    fn crowd(&self, time: i64) -> Vec<u8> {
        let of = |value: fn(&Person) -> f64| self.people.iter().map(value).collect::<Vec<f64>>();
        let pairs = |value: fn(&Person) -> [f64; 2]| self.people.iter().flat_map(value).collect::<Vec<f64>>();
        let mut crowd = Writer::default();
        crowd.header(time, "map");
        crowd.u32_sequence(1..self.people.len() as u32 + 1); // id
        crowd.u32_sequence(self.people.iter().map(|_| 0)); // group
        crowd.f64_sequence(&pairs(|p| [p.x, p.y])); // position
        crowd.f64_sequence(&pairs(|p| [-p.speed, 0.0])); // velocity
        crowd.f64_sequence(&of(|_| PI)); // heading
        crowd.f64_sequence(&of(|_| 0.3)); // radius
        crowd.f64_sequence(&of(|_| 1.7)); // stature
        crowd.f64_sequence(&of(|_| 70.0)); // mass
        crowd.f64_sequence(&of(|p| p.phase)); // gait_phase
        crowd.f64_sequence(&of(|p| p.speed)); // gait_speed
        crowd.message()
    }
}

impl Component for Walkers {
    const KIND: &'static str = "mover";
    const INPUTS: &'static [Port] =
        &[("robots", "crowdcosim_msgs/msg/RobotState", "RIHS01_28baaeeb1730752d8473810cf210793dbacda2f7d928d157c9f3271c09b2b43b")];
    const OUTPUTS: &'static [Port] = &[("crowd", "crowdcosim_msgs/msg/Crowd", "RIHS01_5fe340c3ae1a352a18d075a8f0d745b043fbafaa3795ba2b685c7aad956b7cb9")];

    fn configure(&mut self, config: &Value, setup: &Value) -> Result<(), String> {
        check_options(config, &["count", "speed"])?;
        let number = |value: &Value, name: &str| value.as_f64().ok_or(format!("{name} is {value}, expected a number"));
        self.count = match &config["count"] {
            Value::Null => 20,
            count => count.as_u64().ok_or(format!("count is {count}, expected a whole number"))? as usize,
        };
        self.speed = if config["speed"].is_null() { 1.2 } else { number(&config["speed"], "speed")? };
        self.width = number(&setup["world"]["size"][0], "width")?;
        self.depth = number(&setup["world"]["size"][1], "depth")?;
        self.period = setup["period"].as_i64().ok_or("the setup has no period")?;
        Ok(())
    }

    fn reset(&mut self, alone: bool) -> Result<Vec<Vec<u8>>, String> {
        let count = if alone { 0 } else { self.count };
        let place = |i: usize| Person {
            x: self.width * i as f64 / count as f64,
            y: 0.5 + (i % ROWS) as f64 * ((self.depth - 1.0) / (ROWS - 1) as f64),
            speed: 0.0,
            phase: 0.0,
        };
        self.people = (0..count).map(place).collect();
        Ok(vec![self.crowd(0)])
    }

    fn step(&mut self, time: i64, inputs: &Inputs) -> Result<Vec<Vec<u8>>, String> {
        let mut robots = vec![];
        for message in &inputs[0] {
            let mut robot = Reader::new(message)?;
            robot.header()?;
            robot.text()?; // name
            robots.push(robot.f64s::<2>()?);
        }
        let dt = self.period as f64 * 1e-9;
        let most = MAX_ACCELERATION * dt;
        for person in &mut self.people {
            let mut free: f64 = 1.0;
            for [x, y] in &robots {
                let (dx, dy) = (x - person.x, y - person.y);
                if dx < 0.0 {
                    free = free.min(((dx * dx + dy * dy).sqrt() - 1.0).clamp(0.0, 1.0));
                }
            }
            person.speed += (self.speed * free - person.speed).clamp(-most, most);
            let x = person.x - person.speed * dt;
            person.x = x - self.width * (x / self.width).floor();
            let phase = person.phase + person.speed * dt / STRIDE;
            person.phase = phase - phase.floor();
        }
        Ok(vec![self.crowd(time + self.period)])
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(&mut Walkers::default())
}
