//! What a component in Rust needs to take part in a run: messages as CDR, and the lockstep of docs/protocol.md.
pub mod cdr;
pub mod node;
