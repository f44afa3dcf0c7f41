//! `splineway soak`: random programs, machines and operators until a number of cases has been judged.

use super::numbers::whole;
use crate::view::bar;
use anyhow::{Result, bail};
use serde::Serialize;
use splineway_trials::soak::{Case, PLANTS, Plant, Print, Run, run, shrunk};
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Cases that are reported one by one.
const SHOWN: usize = 20;

/// Runs random programs on random machines while an operator presses anything at any moment, the interrupt
/// comes in between any two accesses to shared state and the background is late; and holds every servo
/// cycle, command and answer against the rules
#[derive(Clone, Debug, clap::Args)]
pub struct Soak {
    /// Cases to be run
    #[arg(long, value_name = "COUNT", default_value_t = 100_000, value_parser = whole(1, u64::MAX / 2))]
    pub cases: u64,
    /// Number of the first case; the same numbers give the same cases
    #[arg(long, value_name = "NUMBER", default_value_t = 0, value_parser = whole(0, u64::MAX / 2))]
    pub seed: u64,
    /// Threads [default: as many as the machine has cores]
    #[arg(long, value_name = "COUNT", value_parser = whole(1_usize, 1024))]
    pub threads: Option<usize>,
    /// Runs this case alone, and tells what happens in it [default: all of them]
    #[arg(long, value_name = "NUMBER", value_parser = whole(0, u64::MAX))]
    pub case: Option<u64>,
    /// Shows the least case that breaks the same rule
    #[arg(long, requires = "case")]
    pub shrink: bool,
    /// Puts a bug between the core and the rest, to see whether it is found (0: the first of the list) [default: none]
    #[arg(long, hide = true)]
    pub plant: Option<usize>,
    /// Print JSON
    #[arg(long, conflicts_with = "case")]
    pub json: bool,
    /// Print nothing but what was broken
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
}

#[derive(Default)]
struct Tally {
    cases: u64,
    blocks: u64,
    cycles: u64,
    broken: BTreeMap<u64, String>,
    /// How often which rule.
    rules: BTreeMap<String, u64>,
    /// Cases that took longer than with stops, and by which share at most, and which.
    slower: u64,
    slowest: (f64, u64),
}

impl Tally {
    fn add(&mut self, number: u64, run: &Run) {
        self.cases += 1;
        self.blocks += run.blocks;
        self.cycles += run.cycles;
        if let Some(ratio) = run.against_stops {
            self.slower += u64::from(ratio > 1.0);
            if ratio > self.slowest.0 {
                self.slowest = (ratio, number);
            }
        }
        if let Some(finding) = &run.finding {
            *self.rules.entry(format!("{:?}", finding.rule)).or_default() += 1;
            let text = format!("{:?}, cycle {}: {}", finding.rule, finding.cycle, finding.text);
            self.broken.insert(number, text);
        }
    }
}

/// What was found, as JSON.
#[derive(Serialize)]
struct Report<'a> {
    cases: u64,
    blocks: u64,
    cycles: u64,
    /// How often which rule was broken.
    findings_by_rule: &'a BTreeMap<String, u64>,
    /// By the number of the case.
    findings: &'a BTreeMap<u64, String>,
    /// Cases that took longer than with a stop after every block.
    slower_cases: u64,
    /// The greatest of their times over that with stops, and its case.
    slowest_ratio: f64,
    slowest_case: u64,
}

impl<'a> Report<'a> {
    fn new(tally: &'a Tally) -> Self {
        Self {
            cases: tally.cases,
            blocks: tally.blocks,
            cycles: tally.cycles,
            findings_by_rule: &tally.rules,
            findings: &tally.broken,
            slower_cases: tally.slower,
            slowest_ratio: tally.slowest.0,
            slowest_case: tally.slowest.1,
        }
    }
}

impl Soak {
    /// Runs the command.
    ///
    /// # Errors
    /// Something was broken.
    pub fn execute(&self) -> Result<()> {
        let plant = self.plant.and_then(|n| PLANTS.get(n)).copied();
        if let Some(number) = self.case {
            return self.one(number, plant);
        }
        let tally = Mutex::new(Tally::default());
        self.all(&tally, plant);
        let tally = lock(&tally);
        if self.json {
            println!("{}", serde_json::to_string_pretty(&Report::new(&tally))?);
        }
        for (number, text) in tally.broken.iter().take(SHOWN) {
            if !self.json {
                println!("case {number}: {text}");
            }
        }
        if !(self.quiet || self.json) {
            println!(
                "{} cases, {} blocks, {} servo cycles judged, {} findings",
                tally.cases,
                tally.blocks,
                tally.cycles,
                tally.broken.len()
            );
            for (rule, count) in &tally.rules {
                println!("{count:8} {rule}");
            }
            println!(
                "slower than with a stop after every block: {} cases, most {:.3} of it (case {})",
                tally.slower, tally.slowest.0, tally.slowest.1
            );
        }
        if !tally.broken.is_empty() {
            bail!(
                "{} findings; `splineway soak --case NUMBER --shrink` repeats one and makes it small",
                tally.broken.len()
            );
        }
        Ok(())
    }

    fn one(&self, number: u64, plant: Option<Plant>) -> Result<()> {
        let mut case = Case::new(number);
        if self.shrink {
            case = shrunk(&case, plant);
        }
        println!("{case:#?}");
        let print: Print = |line| println!("  {line}");
        let run = run(&case, plant, (!self.quiet).then_some(print));
        if let Some(finding) = run.finding {
            bail!("case {number}, cycle {}: {:?}: {}", finding.cycle, finding.rule, finding.text);
        }
        println!("case {number}: nothing found; against stops {:?}", run.against_stops);
        Ok(())
    }

    fn all(&self, tally: &Mutex<Tally>, plant: Option<Plant>) {
        let next = AtomicU64::new(self.seed);
        let end = self.seed.saturating_add(self.cases);
        let bar = bar(self.cases, self.quiet, "{bar:40} {pos}/{len} cases  {eta} left");
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| {
            for _ in 0..self.threads.unwrap_or_else(cores).max(1) {
                scope.spawn(|| {
                    loop {
                        // (Not beyond the end: the last number of all would be followed by 0.)
                        let step = |number: u64| (number < end).then(|| number + 1);
                        let Ok(number) = next.fetch_update(Relaxed, Relaxed, step) else { return };
                        let run = run(&Case::new(number), plant, None);
                        let mut tally = lock(tally);
                        tally.add(number, &run);
                        bar.set_position(tally.cases);
                    }
                });
            }
        });
        bar.finish_and_clear();
    }
}

fn lock(tally: &Mutex<Tally>) -> std::sync::MutexGuard<'_, Tally> {
    // A thread that panicked has found something; what the others found still counts.
    tally.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}
