//! The commands of the `splineway` program.

pub mod bench;
pub mod check;
#[cfg(unix)]
pub mod controller;
pub mod corners;
pub mod files;
pub mod limit;
pub mod paper;
pub mod reading;
mod recorded;
pub mod simulate;
pub mod smooth;
pub mod soak;
pub mod stream;
pub mod thesis;

use splineway_simulator::program::Program;

/// Puts a tolerance from the command line in the place of all that a program names (G64 P); says so if it
/// names any. Exact stops (G61, G9) stay.
pub(crate) fn override_tolerance(program: &mut Program, tolerance: Option<f64>) {
    let Some(tolerance) = tolerance else { return };
    let named = program.moves.iter_mut().filter_map(|step| step.tolerance.take()).count();
    if named > 0 {
        eprintln!(
            "note: --tolerance {tolerance} counts for all; {named} moves name one of their own"
        );
    }
}
