//! The command line, and what only it needs: [`lint`] (a program before it is run), [`stream`] (the host's end of
//! the line, and a controller without a machine), and [`view`] (plots, tables, progress).
//!
//! What does not belong here: reading, running and judging programs (`splineway-simulator`), what the core is
//! compared with (`splineway-studies`), and random programs (`splineway-trials`).

/// Prints a line as the standard macro of this name, but for [`out`]: it never panics.
macro_rules! println {
    () => { $crate::out::line(format_args!("")) };
    ($($argument:tt)*) => { $crate::out::line(format_args!($($argument)*)) };
}

pub mod commands;
pub mod lint;
pub mod out;
pub mod stream;
pub mod view;
