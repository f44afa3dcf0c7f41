//! **splineway** takes tool paths - thousands of short lines, arcs, curves and dwells - and gives one
//! position setpoint per servo cycle for every axis: inside the tolerance band, within every axis's
//! velocity, acceleration and jerk at every instant, and always able to stop. It is `no_std`, never
//! allocates, and runs the same code in `f32` on a Cortex-M4F and in `f64` on a PC.
//!
//! # Architecture
//!
//! ```text
//!  Block ──▶ path ───────────▶ profile ────────────▶ servo ────────▶ Setpoint
//!  push()    nodes and cells,  speed and acceleration  pieces of motion,  tick()
//!            corners in the    at every node: least    one polynomial
//!            tolerance band    time within all limits  per axis
//!  background (producer) side ───────────────────────┤ interrupt side
//! ```
//!
//! The folders of the source are layers. Each knows those below it and none above, and can be tested by itself. From
//! the top to the bottom:
//!
//! ## Borders: `c`, `wire` and `gcode`
//!
//! The interface for C, blocks over a serial line, programs as text: three features, none of which the core needs. They
//! translate to [`Block`]s and [`Controls`] and back. A number from outside is checked here or when its block is
//! pushed, never later. No motion is decided here.
//!
//! ## The planner
//!
//! [`Planner`] is the background side: it takes blocks in, has `path` cut them into cells and `profile` plan over them,
//! and hands plans to `servo`. An operator's commands ([`Controls`]) overtake the blocks: the next poll answers with a plan
//! that branches off at a servo cycle to come, as a rule the next; an answer that comes too late is refused by the
//! interrupt and made again. The planner knows what comes when; the shape of a curve, the row of a limit and the word
//! of an atomic belong below.
//!
//! ## The speed law: `profile`
//!
//! Over a window of cells the unknowns are speed and acceleration at the nodes. Every limit of every axis is a bound on
//! Bernstein coefficients of the very polynomials that will be executed, so it holds at every instant, not only at samples.
//! A barrier method minimises the time, from a guess that may break limits to a motion that keeps them all, in a
//! bounded number of steps; if it has not converged by then, another method takes over that keeps them in every
//! step. A new bound on the motion belongs here. Blocks, tags, commands and the interrupt do not.
//!
//! ## Motion off the path: `jog`
//!
//! A feature: ramps and ways to a place for every axis by itself or along one line, in whole servo cycles. They become plans like
//! any other, while the path rests. It knows no block and no path. Probing is such a way that ends early on an
//! input, and homing some of them (two features more).
//!
//! ## The interrupt side: [`servo`] and [`output`]
//!
//! [`Interpolator::tick`] evaluates one polynomial per axis and knows no planning. Plans arrive whole in the two
//! buffers of a [`Link`], each from a place still ahead of the motion to a stop; the interpolator changes over where they
//! branch off. If nothing arrives it comes to rest on the path, and continues from there when something does. All that
//! contexts share is in `servo`. With the feature `outputs`, what is to switch where waits beside the pieces, by its arc length: a
//! setpoint has one, so an output keeps its place whatever an operator does. [`output`] makes steps, duty cycles or anything else of setpoints, over `embedded-hal`;
//! chips and pins belong to firmware.
//!
//! ## Geometry: `path`
//!
//! Blocks wait until their neighbours are known. Corners become cubic B-splines inside the tolerance band (shaped for least
//! time, or as in Guo, Yan, Wang 2023), runs of short lines one cubic B-spline that is smoothed inside the band (after
//! Naseath 2007), joints with arcs quintic blends. Everything is cut into *cells* between *nodes* that carry position,
//! tangent and curvature: the path is curvature-continuous. A new curve belongs here, and every share of the
//! tolerance. Speed and time do not: of feed and limits, geometry takes what it needs to choose lengths.
//!
//! ## The smoothing kernel: [`spline`]
//!
//! Sweeps over the control points of a cubic B-spline inside a tube, for the runs of `path` and for the crate
//! `splineway-splines`, which smooths splines that come as such. It knows neither blocks nor machines.
//!
//! ## Shape and speed together: `reshape`
//!
//! With the feature `reshape`: a window of an agreed motion is made faster inside the band and the limits, as a spline in time. It knows
//! lines with their bands and a motion, no planner; a planner that is given the memory for it (`Planner::reshape`) uses it while
//! there is nothing else to do, and hands what it finds over as a plan like any other.
//!
//! ## What comes in: [`block`]
//!
//! A [`Block`] is plain data with units, and is checked as a whole when it is pushed: what is refused changes nothing.
//!
//! ## The machine: [`machine`]
//!
//! Limits, settings, their ranges and the sizes of a core, checked once: a [`Limits`] can only be made valid, so that
//! nothing above checks again. Motors that follow several axes (feature `kinematics`) are limits too: rows beside those of the axes.
//!
//! ## Numbers: [`number`]
//!
//! The [`Scalar`], fixed-point [`Coord`]inates that never drift, running numbers that wrap, words that two contexts
//! share. It knows nothing of motion.
//!
//! # What cannot happen
//!
//! What a controller calls cannot panic: the images of `firmware/proof` call planner, interpolator, commands, checks, outputs,
//! both ends of the wire, the reader of G-code and the interface for C, and link only if no panic can be reached. (Not in the
//! proof: the texts of errors, which `core` formats, and the feature `reshape`. It holds for the sizes and the compiler of the images.)
//! The core's own `unsafe` is one instruction, the target's square root, and the border of the interface for C.
//! Invariants between the layers are `debug_assert!`s: they stop a test, and cost a controller nothing.
//!
//! # Where to go on
//!
//! The [`guide`] says how to choose tolerance, jerk and sizes, how to read the plots, and what to do when something looks
//! wrong. `docs/README.md` answers by question.
//!
//! # Example
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
//!     let progress = planner.settle(); // in firmware `poll`: a slice at a time, in the background
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
//! Nothing is allocated: a `Link<S, N, BLOCKS, NODES>` holds 2 x `NODES` pieces, `BLOCKS` blocks, a stretch of spline of
//! fixed size, and `NODES` nodes; a plan is looked for in the memory that its pieces will take. What is made of it are handles. A dense run takes few nodes for many lines, so `BLOCKS` may be small.
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
#[cfg(feature = "grbl")]
pub mod grbl;
#[cfg(feature = "jog")]
pub mod jog;
pub mod machine;
pub mod number;
pub mod output;
mod path;
mod planner;
mod profile;
#[cfg(feature = "reshape")]
pub mod reshape;
pub mod servo;
pub mod spline;
#[cfg(feature = "wire")]
pub mod wire;

pub use block::{Block, Feed, Motion, PushError, Turn};
#[cfg(feature = "outputs")]
pub use block::{Offset, Output, Power, Switch, SwitchError, Trigger};
#[cfg(feature = "home")]
pub use jog::{AxisHome, HomeFailure, HomeFault, HomePhase};
#[cfg(feature = "jog")]
pub use jog::{Jog, JogError};
#[cfg(feature = "probe")]
pub use jog::{Outcome, Overshoot, Probe, ProbeError, Probed};
#[cfg(feature = "outputs")]
pub use machine::{ANALOGUE, DIGITAL, POWERS, SWITCHES};
pub use machine::{AxisLimits, BLOCKS, Config, ConfigError, CornerMode, Limits, NODES};
#[cfg(feature = "travel")]
pub use machine::{AxisTravel, Travel};
#[cfg(feature = "kinematics")]
pub use machine::{Kinematics, Linear, MOTORS, Motor};
pub use number::{Coord, RangeError, Scalar};
#[cfg(feature = "reshape")]
pub use planner::Reshaping;
pub use planner::{Counters, Link, Planner, Progress};
#[cfg(feature = "outputs")]
pub use servo::Switched;
pub use servo::{Activity, Controls, Interpolator, Setpoint};
#[cfg(feature = "probe")]
pub use servo::{Input, Inputs};
