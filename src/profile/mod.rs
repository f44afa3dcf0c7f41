//! The speed law: with what speed and acceleration each node of the path is passed.
//!
//! The unknowns are b = v^2 and the path acceleration a at every node of the window. What is
//! executed between two nodes is one quintic per axis in time that meets position, velocity and
//! acceleration at both ends ([`law`]); every limit is a bound on its Bernstein coefficients
//! ([`rows`]), so it holds at every instant and not only where it was sampled. The sum of the
//! times is minimised by a barrier method ([`solver`], [`barrier`], [`chain`], [`descent`]) from a
//! [`guess`]. A [`window`] of the path is planned at a time; its end is always at rest.

mod barrier;
mod chain;
pub(crate) mod compile;
mod descent;
mod guess;
#[cfg(test)]
mod hull;
pub(crate) mod law;
pub(crate) mod rows;
pub(crate) mod solver;
pub(crate) mod window;
