//! What `splineway soak` runs, shorter; and that it finds what it is to find.

use splineway_trials::soak::{Case, PLANTS, Plant, run};

/// Cases of a run; `SOAK=20 cargo test --release --test soak` runs twenty times as many.
fn cases(count: u64) -> u64 {
    let factor = std::env::var("SOAK").ok().and_then(|factor| factor.parse().ok());
    count * factor.unwrap_or(1u64)
}

/// Cases a bug is looked for in.
const TRIES: u64 = 400;

/// Random programs, machines, operators and producers, with the interrupt and the operator between any two
/// accesses to shared state: no rule is broken.
#[test]
fn no_case_breaks_a_rule() {
    let mut broken = Vec::new();
    for number in 0..cases(400) {
        if let Some(finding) = run(&Case::new(number), None, None).finding {
            broken.push((number, finding));
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// Numbers that have broken a rule before: circles of tens of turns within their band, which the referee lost its place
/// on; in `f32`, a blend of a line and an arc that ended beside its end; arcs at tolerance 0 whose cells are so short that a
/// window of 48 nodes plans them slowly. Arcs of tens of turns in more than 400,000 servo cycles; a stop where the motion comes to rest by
/// its own clock as well; a run behind a line of half a nanometre; a run that turns from a rotary axis to a linear one. An answer that took
/// effect while the next one was dropped, after which the arc length ran back; six dwells in one servo cycle.
#[test]
fn cases_that_were_broken_are_not() {
    const NUMBERS: [u64; 13] = [
        1896, 2084, 2460, 3121, 3256, 4222, 5931, 16_372, 60_245, 100_023, 100_974, 300_143,
        300_296,
    ];
    for number in NUMBERS {
        let finding = run(&Case::new(number), None, None).finding;
        assert!(finding.is_none(), "{number}: {finding:?}");
    }
}

/// Every bug that is put in is found within some hundred cases: so finding nothing means something.
#[test]
fn every_planted_bug_is_found() {
    let mut missed = Vec::new();
    for plant in PLANTS {
        // Bugs in the hand-over show only where contexts come in between each other.
        let of_interleaving = matches!(plant, Plant::OfferFirst | Plant::RefusedIsTaken);
        if of_interleaving && cfg!(not(feature = "interleave")) {
            continue;
        }
        let found = (0..TRIES).find(|&number| {
            let case = Case::new(number);
            run(&case, Some(plant), None).finding.is_some()
                && run(&case, None, None).finding.is_none()
        });
        println!("{plant:?}: case {found:?}");
        if found.is_none() {
            missed.push(plant);
        }
    }
    assert!(missed.is_empty(), "not found: {missed:?}");
}

/// A case follows from its number alone, or nothing could be repeated.
#[test]
fn a_case_repeats() {
    for number in [3, 17, 50, 64] {
        let (once, again) = (Case::new(number), Case::new(number));
        assert_eq!(once, again);
        let (once, again) = (run(&once, None, None), run(&again, None, None));
        assert_eq!((once.cycles, once.blocks, once.log), (again.cycles, again.blocks, again.log));
    }
}
