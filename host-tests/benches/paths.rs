//! Memory of the core, and machining times of the common bench paths beside other speed laws.
//!
//! `cargo bench --bench paths [-- FOLDER]`; the paths lie in `../shared/bench/paths` beside the
//! checkout. Without them there is nothing to do, and it says so. `splineway bench FOLDER --json` gives the
//! same as JSON.

mod common;

use splineway_host::view::table::{print_head, print_memory, print_row};
use splineway_studies::figures::Figures;

fn main() -> anyhow::Result<()> {
    print_memory();
    let paths = common::paths();
    if paths.is_empty() {
        return Ok(());
    }
    print_head();
    for path in Figures::of(&paths, print_row)?.paths {
        anyhow::ensure!(path.broken.is_empty(), "{}: a limit is broken", path.name);
        let slower = path.seconds_f64 > path.seconds_stops;
        anyhow::ensure!(!slower, "{}: slower than stopping", path.name);
    }
    Ok(())
}
