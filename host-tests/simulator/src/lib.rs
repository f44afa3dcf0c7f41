//! The simulator: programs as read from files, run through the core cycle by cycle, and judged.
//!
//! From below: [`input`], [`point`]s, the [`letters`] of axes, [`spline`]s, [`program`]s, the [`machine`], the S-curves of [`scurve`] that tell how long
//! a motion may take, [`run`], [`judge`], and [`record`], what a run leaves. Each imports only what is before it.
//! It is here that the core is compiled for every machine, once for all who simulate.
//!
//! What does not belong here: the command line and plots (`splineway-host`), other speed laws, smoothing and
//! the cases of papers (`splineway-studies`).

pub mod input;
pub mod judge;
pub mod letters;
pub mod machine;
pub mod point;
pub mod program;
pub mod record;
pub mod run;
pub mod scurve;
pub mod spline;
