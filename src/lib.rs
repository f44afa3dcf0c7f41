//! **splineway** takes tool paths - thousands of short lines, arcs, curves and dwells - and gives one
//! position setpoint per servo cycle for every axis: inside the tolerance band, within every axis's
//! velocity, acceleration and jerk at every instant, and always able to stop. It is `no_std`, never
//! allocates, and runs the same code in `f32` on a Cortex-M4F and in `f64` on a PC. What a controller calls cannot
//! panic: the images of `firmware/proof` call planner, interpolator, commands, checks, outputs, both ends
//! of the wire, the reader of G-code and the interface for C, and link only if no panic can be reached. (Not in the
//! proof: the texts of errors, which `core` formats. It holds for the sizes and the compiler of the images.)
//! Its own `unsafe` is one instruction, the target's square root, and the border of the interface for C.
//!
//! # The way of a block
//!
//! ```text
//!  Block ──▶ path ───────────▶ profile ────────────▶ servo ────────▶ Setpoint
//!  push()    nodes and cells,  speed and acceleration  pieces of motion,  tick()
//!            corners in the    at every node: least    one polynomial
//!            tolerance band    time within all limits  per axis
//!  background (producer) side ───────────────────────┤ interrupt side
//! ```
//!
//! - [`block`]: what comes in. A [`Block`] is plain data, checked as a whole when it is pushed.
//! - [`spline`]: the kernel that smooths a cubic B-spline inside a tube, for the runs of `path`; the crate
//!   `splineway-splines` builds on it, for splines that come as such.
//! - `path`: geometry. It knows no speed law; of feed and limits it takes what it needs to choose lengths - how
//!   far a start from rest reaches, and how long a cell may be (`path::cut`) - and hands on the speed that a feed word
//!   asks for. Blocks wait until their neighbours are known; corners
//!   become cubic B-splines inside the tolerance band (shaped for least time, or as in Guo, Yan, Wang
//!   2023), runs of short lines one cubic B-spline that is smoothed inside the band in a set number of
//!   sweeps (after Naseath 2007), joints with arcs quintic blends. Everything is cut into *cells*
//!   between *nodes* that carry position, tangent and curvature: the path is curvature-continuous.
//! - `profile`: the speed law over a window of cells. The unknowns are speed and acceleration at the
//!   nodes; every limit of every axis is a bound on Bernstein coefficients of the very polynomials
//!   that will be executed, so it holds at every instant, not only at samples. A barrier method
//!   minimises the time, from a guess that may break limits to a motion that keeps them all, in a
//!   bounded number of steps; if it has not got there by then, another takes over that keeps them in
//!   every step.
//! - [`servo`]: the interrupt side, which knows no planning. Plans arrive whole in two buffers used in
//!   turn ([`Link`]), each from a place still ahead of the motion to a stop; the [`Interpolator`]
//!   changes over where they branch off. If nothing arrives it comes to rest on the
//!   path, and goes on from there when something does.
//! - [`output`]: step and direction, duty cycles, and a trait for other drives, over embedded-hal.
//! - `gcode`, `wire` and `c`, features: programs as text, blocks over a serial line, and the interface for C.
//! - [`machine`]: limits and settings, checked once. [`number`]: the [`Scalar`], and fixed-point
//!   [`Coord`]inates that never drift.
//!
//! An operator's commands ([`Controls`]) overtake all this: the planner's next poll answers with a
//! plan that branches off at a servo cycle to come, as a rule the next; one that comes too late is refused
//! and made again.
//!
//! Lower modules never import higher ones: `number`, `machine`, `block`, `spline`, `path`, `servo`, `profile`,
//! and on top the [`Planner`].
//!
//! The [`guide`] says how to choose tolerance, jerk and sizes, how to read the plots, and what to do when
//! something looks wrong.
//!
//! # In twenty lines
//!
//! ```
//! use splineway::{Activity, AxisLimits, Block, Config, Coord, Limits, Link, Progress};
//!
//! let axis = AxisLimits::linear(200.0, 2000.0, 50_000.0);
//! let mut config = Config::new(Limits::new([axis; 3])?);
//! config.tolerance = 0.05; // mm
//! // Three axes; the look-ahead and the planning window are of default size.
//! let mut link: Link<f32, 3> = Link::new();
//! let (mut planner, mut interpolator) = link.split(config, [Coord::ZERO; 3])?;
//! for (line, (x, y)) in [(10.0, 0.0), (10.0, 10.0), (0.0, 10.0)].into_iter().enumerate() {
//!     let to = [Coord::from_mm(x)?, Coord::from_mm(y)?, Coord::ZERO];
//!     planner.push(&Block::line(to, 100.0, line as u32 + 1))?;
//! }
//! planner.finish();
//! loop {
//!     let progress = planner.poll(); // in the background
//!     let setpoint = interpolator.tick(); // in the servo interrupt
//!     // ... drive the axes to setpoint.position_nm(0), ...
//!     if progress == Progress::Done && setpoint.activity == Activity::Idle {
//!         assert_eq!(setpoint.position_nm(1), 10_000_000);
//!         break;
//!     }
//! }
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! # Memory
//!
//! Nothing is allocated: a `Link<S, N, BLOCKS, NODES>` holds 2 x `NODES` pieces, a
//! `Planner<S, N, BLOCKS, NODES>` `BLOCKS` blocks, a stretch of spline of fixed size, and `NODES` nodes
//! with the solver's workspace. A dense run takes few nodes for many lines, so `BLOCKS` may be small.
//! `size_of` tells the bytes; `docs/figures.md` has a table.
#![no_std]
#![deny(unsafe_code)]

#[cfg(any(test, feature = "interleave"))]
extern crate std;

pub mod block;
#[cfg(doc)]
#[doc = include_str!("guide.md")]
pub mod guide {}
/// The README's program is compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
#[cfg(feature = "c")]
pub mod c;
#[cfg(feature = "gcode")]
pub mod gcode;
pub mod machine;
pub mod number;
pub mod output;
mod path;
mod planner;
mod profile;
pub mod servo;
pub mod spline;
#[cfg(feature = "wire")]
pub mod wire;

pub use block::{Block, Feed, Motion, PushError, Turn};
pub use machine::{AxisLimits, BLOCKS, Config, ConfigError, CornerMode, Limits, NODES};
pub use number::{Coord, RangeError, Scalar};
pub use planner::{Counters, Planner, Progress};
pub use servo::{Activity, Controls, Interpolator, Link, Setpoint};
