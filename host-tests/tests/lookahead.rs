//! The default look-ahead, 16 blocks and 64 nodes, does as well as one of 256 blocks and 512 nodes, on every path of our own making.

use splineway_simulator::judge::{judged, violations};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::poly;
use splineway_simulator::run::{Events, Precision};
use splineway_studies::paths;

/// By how much a path takes longer at most, as a share of its time. Dense lines at the narrower tolerance need cells so short that
/// 64 nodes hardly hold the distance to a stop.
const LONGER: f64 = 0.01;
const NARROW: (f64, f64) = (0.02, 0.02);

#[test]
fn the_default_is_deep_enough() {
    for path in paths::all().unwrap() {
        let program = poly::parse(&path.text()).unwrap();
        let mut machine = Machine::default();
        machine.apply(program.header.as_ref().unwrap());
        let time = |lookahead: usize| {
            let machine = Machine { lookahead, ..machine.clone() };
            let (verdict, _) =
                judged(&program, &machine, Precision::F32, &Events::default()).unwrap();
            let broken = violations(&verdict);
            assert!(broken.is_empty(), "{} {}: {broken:?}", path.name, path.tolerance);
            verdict.time
        };
        let (deep, default) = (time(256), time(16));
        let most = if path.tolerance < NARROW.0 { NARROW.1 } else { LONGER };
        assert!(
            default <= deep * (1.0 + most),
            "{} {}: {default} s, {deep} s with a deep one",
            path.name,
            path.tolerance
        );
    }
}
