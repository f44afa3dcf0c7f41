//! Random programs on random machines, while an operator presses anything at any moment, the interrupt
//! comes in between any two accesses to shared state, and the background is late; and the rules that all of
//! it must keep.

mod api;
mod bound;
mod case;
mod draw;
mod path;
mod plant;
mod referee;
mod setting;
mod shrink;
mod world;

pub use case::{Case, Moment, Press, Producer, Tempo};
pub use plant::{PLANTS, Plant};
pub use referee::{Finding, Print, Rule};
pub use setting::{Core, Setting};
pub use shrink::shrunk;
pub use world::{Run, run};
