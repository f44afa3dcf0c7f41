//! G-code, one line in, actions out (feature `gcode`): the same reader on the host and on the board.
//!
//! # The rule
//!
//! What is not understood is refused, with the column and the code, and nothing of its line is done. Words belong
//! to the code that takes them: a word that no code of its line takes is refused, so a setting like `M201 X500`
//! can never become a move. What is left out with a mere [`Note`] cannot change where the tool goes.
//!
//! # From a line to actions
//!
//! `lexer` makes words of it, `groups` sorts its codes into modal groups, of each at most one; then [`Reader::line`]
//! carries them out in the order of RS274/NGC - feed, spindle, tool, coolant, dwell, modes, offsets, motion, stop -
//! and [`Reader::action`] gives what came of it, one [`Action`] at a time:
//!
//! ```
//! use splineway::gcode::{Action, Reader, Settings};
//!
//! let mut reader = Reader::new(&Settings::default());
//! let mut moves = 0;
//! for (number, line) in ["G21 G90 M3 S1000", "G1 X10 F600 (cut)", "G81 X5 Y5 Z-2 R1", "M2"].iter().enumerate() {
//!     reader.line(number as u32 + 1, line.as_bytes())?;
//!     while let Some(action) = reader.action() {
//!         match action {
//!             Action::Move(_) => moves += 1, // to `Planner::push`, by `Action::block`
//!             Action::Event(event) => assert_eq!(event.code.to_string(), "M3"),
//!             Action::End => {}
//!             other => panic!("{other:?}"),
//!         }
//!     }
//! }
//! assert_eq!(moves, 5); // a line, then over the hole, down to R, drill, and back up
//! # Ok::<(), splineway::gcode::Refusal>(())
//! ```
//!
//! # What is understood
//!
//! | codes | |
//! |---|---|
//! | G0 G1 G2 G3, G5 G5.1 | lines, arcs and helices (I J K, or R; P turns), cubic and quadratic curves |
//! | G5.2 P L, G5.3 | NURBS in the XY plane, up to 64 control points, order 3 to 10, as LinuxCNC has them (feature `nurbs`) |
//! | G4, G9, G61 G61.1, G64 P Q | dwell, exact stops, tolerance (Q is taken for within P) |
//! | G17-G19, G20 G21, G90 G91, G90.1 G91.1, G93 G94 | plane, units, distances, centres, feed modes |
//! | G54-G59.3, G10 L2 L20, G92-G92.3, G52, G53 | work offsets, shifts, machine coordinates |
//! | G43 G43.1 G49, G68 G69 | length of the tool along Z, rotation in the plane |
//! | G28 G30, G28.1 G30.1 | reference points |
//! | G73, G80-G83, G98 G99, L | drilling, with exact stops; a chip is broken by 0.254 mm, as in LinuxCNC |
//! | G38.2-G38.5, G31 | probes, towards and away, with and without an error; the caller says where the machine then stands |
//! | M98 P L, M99, O | subprograms; finding the line is up to the caller |
//! | M0 M1 M60, M6 M61, M3-M5 M19, M7-M9, M48-M53, M62-M65, S, T | events, in order with the motion |
//! | M62-M65 P, M67 M68 E Q | outputs in time with the path (feature `outputs`, [`Settings`] has them on): with the next motion, or at rest |
//! | S, M3 M4 M5 | of a laser in [`Settings`], its power, without a stop |
//! | M2, M30, % | the end |
//! | G8 G15 G40 G50 G69 G97 | switch off what is not there |
//!
//! What becomes of a code is told by [`Dialect::knows`]. Everything else is refused by name: cutter compensation, scaling, polar coordinates, threads, boring
//! cycles, parameters, expressions. What printers have besides is in [`Dialect::Marlin`].
//!
//! Cost: a pass over the bytes, some 30 multiplications in `f64` per line, a few hundred per block of a NURBS of order 3; a [`Reader`] has
//! 7.1 kB, with NURBS 8.7. Positions are [`Coord`](crate::Coord)s,
//! so relative programs do not drift.

mod action;
mod arcs;
mod cycles;
mod dialect;
mod drilling;
mod error;
mod event;
mod groups;
mod known;
mod lexer;
mod machine;
mod modal;
mod motion;
pub(crate) mod number;
mod nurbs;
mod offsets;
mod probing;
mod reader;
mod shifts;
mod state;
#[cfg(feature = "outputs")]
mod switches;
#[cfg(test)]
mod tests;
mod words;

pub use action::Action;
pub use dialect::Dialect;
pub use error::{Note, Reason, Refusal};
pub use event::{Code, Event};
pub use known::Known;
pub use nurbs::POINTS;
pub use offsets::{OFFSETS, Place, Setup, TOOLS};
pub use probing::ProbeMove;
pub use reader::{Reader, Settings};
pub use state::{JogLine, Modes, State};
#[cfg(feature = "outputs")]
pub use switches::{Coolant, Laser};

/// Letters of the axes in the order of their indices.
pub const LETTERS: [char; AXES] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];
/// Most axes.
pub const AXES: usize = 9;
/// What a code misses that has none.
pub(crate) const AXIS_WORDS: &str = "axis words";
/// Most words of a line.
const WORDS: usize = 48;

/// Whether an axis turns: A, B, C.
const fn is_rotary(axis: usize) -> bool {
    matches!(axis, 3..=5)
}
