//! The handshake and the lockstep: hosts one component until the orchestrator says stop.
use std::{env, error::Error, fmt::Write as _, process, time::Instant};

use serde_json::{json, Value};
use zenoh::handlers::{FifoChannel, FifoChannelHandler};
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Config, Session, Wait};

use crate::cdr::{Reader, Writer};

const RESET: u8 = 0;
const STEP: u8 = 1;
const STOP: u8 = 3;

/// A port: its name, its ROS 2 type, and that type's hash.
pub type Port = (&'static str, &'static str, &'static str);

/// The messages of a step: for each input port, in the order of `inputs`, those of all its sources.
pub type Inputs = Vec<Vec<Vec<u8>>>;

/// One component. What it returns are its outputs as CDR, in the order of `OUTPUTS`.
pub trait Component {
    /// `reactor` (sensor, controller) or `mover` (crowd, drive).
    const KIND: &'static str;
    const INPUTS: &'static [Port];
    const OUTPUTS: &'static [Port];

    /// Take the options and the setup, or say what is wrong with them.
    fn configure(&mut self, config: &Value, setup: &Value) -> Result<(), String>;

    /// Begin an episode, with or without people; a mover gives its state at t = 0, others nothing.
    fn reset(&mut self, alone: bool) -> Result<Vec<Vec<u8>>, String>;

    /// One step from the state at `time` [ns].
    fn step(&mut self, time: i64, inputs: &Inputs) -> Result<Vec<Vec<u8>>, String>;
}

/// One source of an input, and the newest message that came from it.
struct Source {
    name: String,
    every: u64,
    queue: Subscriber<FifoChannelHandler<Sample>>,
    held: (u64, u64),
    message: Vec<u8>,
}

impl Source {
    /// Wait for the message that belongs to this tick.
    fn read(&mut self, episode: u64, tick: u64) -> Result<Vec<u8>, String> {
        let wanted = (episode, if self.every == 0 { 0 } else { tick / self.every * self.every });
        while self.held != wanted {
            let sample = self.queue.recv().map_err(|error| error.to_string())?;
            let label = sample.attachment().map(|a| a.to_bytes().into_owned()).unwrap_or_default();
            let number = |at: usize| label.get(at..at + 8).map(|b| u64::from_le_bytes(b.try_into().unwrap()));
            self.held = number(0).zip(number(8)).ok_or(format!("{}: no label", self.name))?;
            if self.held > wanted {
                return Err(format!("input from {} is of tick {}, expected {}", self.name, self.held.1, wanted.1));
            }
            self.message = sample.payload().to_bytes().into_owned();
        }
        Ok(self.message.clone())
    }
}

struct Node<'a, C: Component> {
    component: &'a mut C,
    session: Session,
    run: String,
    key: String,
    every: u64,
    inputs: Vec<Vec<Source>>,
    outputs: Vec<Publisher<'static>>,
    done: Option<Publisher<'static>>,
}

/// Host the component whose address is in the environment; returns when the orchestrator says stop.
pub fn run<C: Component>(component: &mut C) -> Result<(), Box<dyn Error>> {
    let [endpoint, run, name] = ["ENDPOINT", "RUN", "COMPONENT"].map(|v| env::var(format!("CROWDCOSIM_{v}")));
    let (run, key) = (run.clone()?, format!("{}/{}", run?, name?));
    let mut config = json!({"mode": "client", "connect": {"endpoints": [endpoint?], "exit_on_failure": true},
        "scouting": {"multicast": {"enabled": false}, "gossip": {"enabled": false}}});
    if let [Ok(user), Ok(password)] = ["USER", "PASSWORD"].map(|v| env::var(format!("CROWDCOSIM_{v}"))) {
        config["transport"] = json!({"auth": {"usrpwd": {"user": user, "password": password}}});
    }
    let session = zenoh::open(Config::from_json5(&config.to_string()).map_err(|e| e.to_string())?)
        .wait().map_err(|e| e.to_string())?;
    let mut node = Node { component, session, run, key, every: 1, inputs: vec![], outputs: vec![], done: None };
    node.live().map_err(|error| error.to_string().into())
}

impl<C: Component> Node<'_, C> {
    fn live(&mut self) -> zenoh::Result<()> {
        let liveliness = self.session.liveliness();
        let alive = format!("{}/orchestrator/alive", self.run);
        let leave = |token: Sample| if token.kind() == SampleKind::Delete { process::exit(1) };
        let _watch = liveliness.declare_subscriber(alive).history(true).callback(leave).wait()?;
        let tick_key = format!("{}/orchestrator/tick", self.run);
        let ticks = self.session.declare_subscriber(tick_key).with(FifoChannel::new(1024)).wait()?;
        let control = format!("{}/control", self.key);
        let requests = self.session.declare_queryable(control).with(FifoChannel::new(16)).wait()?;
        let _token = liveliness.declare_token(format!("{}/alive", self.key)).wait()?;
        loop {
            let query = requests.recv()?;
            let request = query.parameters().as_str().to_owned();
            let body = query.payload().map(|p| p.to_bytes().into_owned()).unwrap_or_default();
            let answer = self.answer(&request, &body).unwrap_or_else(|error| json!({ "error": error }));
            query.reply(query.key_expr().clone(), answer.to_string()).wait()?;
            if request == "connect" {
                break;
            }
        }
        while self.obey(&ticks.recv()?.payload().to_bytes())? != STOP {}
        Ok(())
    }

    fn answer(&mut self, request: &str, body: &[u8]) -> Result<Value, String> {
        let body: Value = serde_json::from_slice(body).map_err(|error| error.to_string())?;
        match request {
            "hello" => {
                let ports = |ports: &[Port]| -> Vec<Value> {
                    ports.iter().map(|(n, t, h)| json!({"name": n, "type": t, "hash": h})).collect()
                };
                return Ok(json!({"protocol": 1, "kind": C::KIND, "inputs": ports(C::INPUTS), "outputs": ports(C::OUTPUTS)}));
            }
            "configure" => {
                self.component.configure(&body["config"], &body["setup"])?;
                self.every = body["every"].as_u64().ok_or("every is no number")?;
                self.inputs = C::INPUTS.iter().map(|port| self.sources(&body["inputs"][port.0])).collect::<Result<_, _>>()?;
            }
            "connect" => {
                self.outputs = C::OUTPUTS.iter().map(|port| self.publisher(port.0)).collect::<Result<_, _>>()?;
                self.done = Some(self.publisher("done")?);
            }
            other => return Err(format!("there is no request '{other}'")),
        }
        Ok(json!({}))
    }

    fn sources(&self, listed: &Value) -> Result<Vec<Source>, String> {
        let text = |source: &Value, key: &str| source[key].as_str().map(String::from).ok_or(format!("a source has no {key}"));
        listed.as_array().into_iter().flatten().map(|source| {
            let name = format!("{}/{}", text(source, "component")?, text(source, "port")?);
            let queue = self.session.declare_subscriber(format!("{}/{name}", self.run)).with(FifoChannel::new(1024));
            let queue = queue.wait().map_err(|error| error.to_string())?;
            let every = source["every"].as_u64().ok_or("a source has no every")?;
            Ok(Source { name, every, queue, held: (0, 0), message: vec![] })
        }).collect()
    }

    fn publisher(&self, port: &str) -> Result<Publisher<'static>, String> {
        let builder = self.session.declare_publisher(format!("{}/{port}", self.key)).express(true);
        builder.congestion_control(CongestionControl::Block).wait().map_err(|error| error.to_string())
    }

    /// Do what a tick says; its phase.
    fn obey(&mut self, message: &[u8]) -> zenoh::Result<u8> {
        let mut tick = Reader::new(message)?;
        let (phase, episode, number) = (tick.u8()?, tick.u64()?, tick.u64()?);
        let (period, time, setup) = (tick.i64()?, tick.i64()?, tick.text()?);
        let result = match phase {
            RESET => serde_json::from_str::<Value>(&setup).map_err(|error| error.to_string())
                .and_then(|setup| self.component.reset(setup["alone"] == true)).map(|outputs| (outputs, 0, 0, 0)),
            STEP if number % self.every == 0 => self.step(episode, number, time).map(|(outputs, elapsed)| {
                let label = number + if C::KIND == "mover" { self.every } else { 0 };
                (outputs, label, label as i64 * period, elapsed)
            }),
            _ => return Ok(phase),
        };
        match result {
            Ok((outputs, label, time, elapsed)) => {
                let attachment = [episode, label, time as u64, elapsed].map(u64::to_le_bytes).concat();
                for (publisher, output) in self.outputs.iter().zip(outputs) {
                    publisher.put(output).attachment(attachment.clone()).wait()?;
                }
                if phase == RESET {
                    self.say_done(phase, number, "")?;
                }
            }
            Err(error) => {
                self.say_done(phase, number, &error)?;
                return Err(error.into());
            }
        }
        Ok(phase)
    }

    fn step(&mut self, episode: u64, tick: u64, time: i64) -> Result<(Vec<Vec<u8>>, u64), String> {
        let mut inputs = Inputs::new();
        for sources in &mut self.inputs {
            inputs.push(sources.iter_mut().map(|source| source.read(episode, tick)).collect::<Result<_, _>>()?);
        }
        let began = Instant::now();
        let outputs = self.component.step(time, &inputs)?;
        Ok((outputs, began.elapsed().as_nanos() as u64))
    }

    fn say_done(&self, phase: u8, tick: u64, error: &str) -> zenoh::Result<()> {
        let message = Writer::default().u8(phase).u64(tick).u8(error.is_empty().into()).text(error).i64(0).message();
        self.done.as_ref().ok_or("a tick came before connect")?.put(message).wait()
    }
}

/// Refuse options that are not among `known`.
pub fn check_options(config: &Value, known: &[&str]) -> Result<(), String> {
    let mut unknown = String::new();
    for key in config.as_object().into_iter().flat_map(|options| options.keys()) {
        if !known.contains(&key.as_str()) {
            let _ = write!(unknown, "{}'{key}'", if unknown.is_empty() { "" } else { ", " });
        }
    }
    if unknown.is_empty() { Ok(()) } else { Err(format!("there is no option {unknown}, expected {}", known.join(", "))) }
}
