//! From a case that breaks a rule to the least one that still does.

use super::case::{Case, Tempo};
use super::plant::Plant;
use super::world::run;
use std::time::{Duration, Instant};

/// How long to try.
const PATIENCE: Duration = Duration::from_secs(20);

/// The least case found that breaks the same rule.
pub fn shrunk(case: &Case, plant: Option<Plant>) -> Case {
    let began = Instant::now();
    let Some(finding) = run(case, plant, None).finding else { return case.clone() };
    let breaks = |case: &Case| {
        run(case, plant, None).finding.is_some_and(|found| found.rule == finding.rule)
    };
    let mut best = case.clone();
    loop {
        let before = best.clone();
        for candidate in simpler(&best) {
            if began.elapsed() > PATIENCE {
                return best;
            }
            if candidate != best && breaks(&candidate) {
                best = candidate;
                break;
            }
        }
        if best == before {
            return best;
        }
    }
}

/// Cases that are simpler by one thing each, the greatest things first.
fn simpler(case: &Case) -> Vec<Case> {
    let mut list = Vec::new();
    let mut cut = case.steps.len();
    while cut > 0 {
        for from in (0..case.steps.len()).step_by(cut) {
            let mut one = case.clone();
            one.steps.drain(from..(from + cut).min(case.steps.len()));
            if !one.steps.is_empty() {
                list.push(one);
            }
        }
        cut /= 2;
    }
    let mut cut = case.presses.len();
    while cut > 0 {
        for from in (0..case.presses.len()).step_by(cut) {
            let mut one = case.clone();
            one.presses.drain(from..(from + cut).min(case.presses.len()));
            list.push(one);
        }
        cut /= 2;
    }
    let mut with = |change: &dyn Fn(&mut Case)| {
        let mut one = case.clone();
        change(&mut one);
        list.push(one);
    };
    with(&|one| one.tempo = Tempo { inside: 0.0, rough: 0.0, burst: 1, polls: 1 });
    with(&|one| one.tempo.rough = 0.0);
    with(&|one| one.tempo.inside = 0.0);
    with(&|one| one.tempo.polls = 1);
    with(&|one| {
        one.producer.every = 0;
        one.producer.finishes = false;
    });
    with(&|one| one.producer.stubborn = false);
    with(&|one| one.producer.patience = 0);
    with(&|one| one.setting.lambda = None);
    with(&|one| one.setting.iterations = 40);
    with(&|one| one.setting.sweeps = 8);
    with(&|one| one.setting.cycle = 1.0e-3);
    with(&|one| one.setting.lead = 0.01);
    with(&|one| one.setting.start_delay = 0.05);
    with(&|one| one.setting.tolerance = 0.01);
    with(&|one| one.setting.rotary_from = 9);
    with(&|one| one.setting.start = [0.0; 9]);
    with(&|one| {
        let first = one.setting.axes[0];
        one.setting.axes.fill(first);
    });
    for n in 0..case.presses.len() {
        with(&|one| one.presses[n].accesses = 0);
        with(&|one| one.presses[n].cycles /= 2);
    }
    for n in 0..case.steps.len() {
        with(&|one| one.steps[n].tolerance = None);
        with(&|one| one.steps[n].exact_stop = false);
    }
    list
}
