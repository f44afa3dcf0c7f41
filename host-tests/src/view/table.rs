//! The figures as text.

use splineway_studies::figures::{Memory, PathFigures};

/// The memory table.
pub fn print_memory() {
    for Memory { scalar, axes, blocks, nodes, link, planner } in Memory::table() {
        println!(
            "{scalar:<4} {axes} axes {blocks:>4} blocks {nodes:>4} nodes   link {link:>7} bytes   planner {planner:>7} bytes"
        );
    }
}

/// Heads of the columns of [`print_row`].
pub fn print_head() {
    println!(
        "{:<20} {:>9} {:>9} {:>10} {:>10} {:>10} {:>8} {:>7} {:>7} {:>7} {:>9} {:>8}",
        "path",
        "f64, s",
        "f32, s",
        "stops, s",
        "trapez., s",
        "S-curve, s",
        "dev/tol",
        "v",
        "a",
        "j",
        "ns/block",
        "ns/tick"
    );
}

/// A path's row.
pub fn print_row(path: &PathFigures) {
    let [velocity, acceleration, jerk] = path.peaks;
    println!(
        "{:<20} {:>9.3} {:>9.3} {:>10.3} {:>10.3} {:>10.3} {:>8.3} {velocity:>7.4} {acceleration:>7.4} {jerk:>7.4} {:>9.0} {:>8.1}  {}",
        path.name,
        path.seconds_f64,
        path.seconds_f32,
        path.seconds_stops,
        path.seconds_trapezoid,
        path.seconds_s_curve,
        path.deviation,
        path.ns_per_block,
        path.ns_per_tick,
        if path.broken.is_empty() { "ok".to_owned() } else { path.broken.join("; ") }
    );
}
