//! `splineway soak`: random programs until a number of blocks has been judged.

use crate::trial::{Case, Outcome};
use anyhow::{Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Cases that are reported one by one.
const SHOWN: usize = 20;

/// Runs random programs on random machines, a quarter of them with an operator who presses anything,
/// and judges every servo cycle: limits of every axis, band, end point; and tells how times compare with
/// stopping everywhere.
#[derive(Clone, Debug, clap::Args)]
pub struct Soak {
    /// Blocks to be run.
    #[arg(long, default_value_t = 1_000_000)]
    pub blocks: u64,
    /// Number of the first case; the same numbers give the same cases.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Threads; as many as the machine has cores if left out.
    #[arg(long)]
    pub threads: Option<usize>,
    /// Runs this case alone.
    #[arg(long)]
    pub case: Option<u64>,
    /// Print nothing but what was broken.
    #[arg(long)]
    pub quiet: bool,
}

#[derive(Default)]
struct Tally {
    cases: u64,
    blocks: u64,
    cycles: u64,
    broken: Vec<(u64, String)>,
    /// Cases that took longer than with stops, and by which share at most, and which.
    slower: u64,
    slowest: (f64, u64),
}

impl Tally {
    fn add(&mut self, number: u64, outcome: Result<Outcome>) {
        self.cases += 1;
        let outcome = outcome.unwrap_or_else(|error| Outcome {
            broken: vec![format!("{error:#}")],
            ..Outcome::default()
        });
        self.blocks += outcome.blocks;
        self.cycles += outcome.cycles;
        self.slower += u64::from(outcome.against_stops > 1.0);
        if outcome.against_stops > self.slowest.0 {
            self.slowest = (outcome.against_stops, number);
        }
        self.broken.extend(outcome.broken.into_iter().map(|text| (number, text)));
    }
}

impl Soak {
    /// Runs the command.
    ///
    /// # Errors
    /// Something was broken.
    pub fn execute(&self) -> Result<()> {
        let tally = Mutex::new(Tally::default());
        if let Some(number) = self.case {
            lock(&tally).add(number, Case::new(number).run());
        } else {
            self.run(&tally);
        }
        let tally = lock(&tally);
        for (number, text) in tally.broken.iter().take(SHOWN) {
            println!("case {number}: {text}");
        }
        if !self.quiet {
            println!(
                "{} cases, {} blocks, {} servo cycles judged, {} findings",
                tally.cases,
                tally.blocks,
                tally.cycles,
                tally.broken.len()
            );
            // A rounded corner may be longer than a sharp one: where feeds are so slow that a stop costs
            // nothing, that is time.
            println!(
                "slower than with a stop after every block: {} cases, most {:.3} of it (case {})",
                tally.slower, tally.slowest.0, tally.slowest.1
            );
        }
        if !tally.broken.is_empty() {
            bail!("{} findings; `splineway soak --case NUMBER` repeats one", tally.broken.len());
        }
        Ok(())
    }

    fn run(&self, tally: &Mutex<Tally>) {
        let next = AtomicU64::new(self.seed);
        let bar = if self.quiet || !std::io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            ProgressBar::new(self.blocks)
        };
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} blocks  {eta} left") {
            bar.set_style(style);
        }
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| {
            for _ in 0..self.threads.unwrap_or_else(cores).max(1) {
                scope.spawn(|| {
                    while lock(tally).blocks < self.blocks {
                        let number = next.fetch_add(1, Relaxed);
                        let outcome = Case::new(number).run();
                        let mut tally = lock(tally);
                        tally.add(number, outcome);
                        bar.set_position(tally.blocks.min(self.blocks));
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
