//! The speed law: with what speed and acceleration each node of the path is passed.
//!
//! The unknowns are b = v^2 and the path acceleration a at every node of the window. What is
//! executed between two nodes is one quintic per axis in time that meets position, velocity and
//! acceleration at both ends ([`law`]); every limit is a bound on its Bernstein coefficients
//! ([`rows`]), so it holds at every instant and not only where it was sampled. The sum of the
//! times is minimised over a stretch of a [`window`] of the path, whose end is always at rest.
//!
//! What [`bounds`] a cell besides its shape is set when it comes into the window. A [`solver`] is the workspace, a [`problem`] what it is put to: what is minimised, and its second-order model of
//! [`barrier`] ([`relaxation`]) and time ([`model`]). It is solved by Newton's method ([`descent`], on a block [`tridiagonal`]
//! system) from a [`guess`] (or from slow seeds: [`seeding`]), step by step ([`solving`]). What comes out is made pieces of motion by [`compile`].
//!
//! A hold needs none of this: it runs the motion as agreed by a [`clock`] that slows down ([`slowed`]).

pub(crate) mod barrier;
pub(crate) mod bounds;
pub(crate) mod clock;
pub(crate) mod compile;
mod descent;
pub(crate) mod guess;
#[cfg(test)]
mod hull;
pub(crate) mod law;
mod model;
mod problem;
pub(crate) mod relaxation;
pub(crate) mod rows;
pub(crate) mod seeding;
pub(crate) mod slowed;
pub(crate) mod solver;
pub(crate) mod solving;
#[cfg(test)]
mod tests;
mod tridiagonal;
pub(crate) mod window;
