//! The host side of splineway: reading tool paths, simulating servo cycles, judging and showing.

/// Prints a line as the standard macro of this name, but for [`out`]: it never panics.
macro_rules! println {
    () => { $crate::out::line(format_args!("")) };
    ($($argument:tt)*) => { $crate::out::line(format_args!($($argument)*)) };
}

pub mod baseline;
pub mod commands;
pub mod corners;
pub mod figures;
pub mod lint;
pub mod machine;
pub mod out;
pub mod program;
pub mod reference;
pub mod run;
pub mod smoothing;
pub mod stream;
pub mod trial;
pub mod view;
