//! Turn to the goal and drive, blind to people: the twin of examples/plain_controller.py.
use std::f64::consts::TAU;

use crowdcosim_examples::cdr::{Reader, Writer};
use crowdcosim_examples::node::{check_options, run, Component, Inputs, Port};
use serde_json::Value;

#[derive(Default)]
struct Straight {
    speed: f64,
    max_turn_rate: f64,
}

impl Component for Straight {
    const KIND: &'static str = "reactor";
    const INPUTS: &'static [Port] = &[
        ("odometry", "nav_msgs/msg/Odometry", "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"),
        ("goal", "crowdcosim_msgs/msg/Goal", "RIHS01_1de622eef3e1ab66f16bb99b1b3c8186696bdbf81ef9cd44beb5edca05d7865d"),
    ];
    const OUTPUTS: &'static [Port] =
        &[("twist", "geometry_msgs/msg/Twist", "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a")];

    fn configure(&mut self, config: &Value, setup: &Value) -> Result<(), String> {
        check_options(config, &["speed"])?;
        let robots = setup["robots"].as_array().ok_or("the setup has no robots")?;
        let robot = robots.iter().find(|robot| robot["name"] == setup["robot"]).ok_or("I belong to no robot")?;
        let limit = |key: &str| robot["model"][key].as_f64().ok_or(format!("the robot has no {key}"));
        self.max_turn_rate = limit("max_angular_velocity")?;
        self.speed = match &config["speed"] {
            Value::Null => limit("max_speed")?,
            speed => speed.as_f64().ok_or(format!("speed is {speed}, expected a number"))?,
        };
        Ok(())
    }

    fn reset(&mut self, _alone: bool) -> Result<Vec<Vec<u8>>, String> {
        Ok(vec![])
    }

    fn step(&mut self, _time: i64, inputs: &Inputs) -> Result<Vec<Vec<u8>>, String> {
        let mut odometry = Reader::new(&inputs[0][0])?;
        odometry.header()?;
        odometry.text()?; // child frame
        let [x, y, _z, _qx, _qy, qz, qw] = odometry.f64s()?;
        let mut goal = Reader::new(&inputs[1][0])?;
        goal.header()?;
        goal.text()?; // robot
        let [goal_x, goal_y, direction_x, direction_y, tolerance] = goal.f64s()?;

        let (mut speed, mut max_turn_rate) = (self.speed, self.max_turn_rate);
        let mut bearing = direction_y.atan2(direction_x); // a line to cross, at right angles
        if direction_x == 0.0 && direction_y == 0.0 {
            // a disc to enter
            bearing = (goal_y - y).atan2(goal_x - x);
            if (goal_x - x).hypot(goal_y - y) <= tolerance {
                (speed, max_turn_rate) = (0.0, 0.0);
            }
        }
        let away = bearing - 2.0 * qz.atan2(qw);
        let error = away - TAU * (away / TAU).round_ties_even();
        let turn = (2.0 * error).clamp(-max_turn_rate, max_turn_rate);
        let mut twist = Writer::default();
        for value in [speed * error.cos().max(0.0), 0.0, 0.0, 0.0, 0.0, turn] {
            twist.f64(value);
        }
        Ok(vec![twist.message()])
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run(&mut Straight::default())
}
