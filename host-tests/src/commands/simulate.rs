//! `splineway simulate`: a file through the core, cycle by cycle.

use super::files::{self, named};
use super::reading::{Reading, setup};
use super::recorded::{self, Places, Recorded, is_page};
use crate::view::page::Overlay;
use crate::view::{Curve, Progress, Scene, plot, plot_speeds};
use anyhow::{Context, Result, bail};
use splineway_simulator::judge::{Judge, Track, violations};
use splineway_simulator::machine::{Axis, Machine, Mode};
use splineway_simulator::program::{self, Finding, LETTERS, Program, ReadOptions, Speed};
use splineway_simulator::record::recording::Watched;
use splineway_simulator::record::{CsvOut, Report, Trace};
use splineway_simulator::run::{
    Events, Happenings, Observer, Precision, Stats, Stops, run_with, sharp_corners,
};
use splineway_studies::baseline::{self, Law};
use std::path::PathBuf;

/// Feed of programs that name none, mm/s.
const DEFAULT_FEED: f64 = 50.0;

const EXAMPLES: &str = "\
Examples:
  splineway simulate host-tests/data/butterfly.json --tolerance 0.05 --plot butterfly.html
  splineway simulate part.gcode --machine mill.toml --report part.json
  splineway simulate path.txt --scalar f32 --setpoints setpoints.csv

Exit codes: 0 done, 1 error or a limit broken, 2 wrong usage.";

/// Runs a tool path through the motion core and judges every servo cycle.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Simulate {
    /// G-code (.ngc .nc .gcode .tap ...), "-" for G-code on standard input, poly-line (.txt) or NURBS curve (.json).
    pub file: PathBuf,
    /// Machine description (TOML); a small milling machine if left out.
    #[arg(long, value_name = "TOML")]
    pub machine: Option<PathBuf>,
    /// Greatest distance from the programmed path, mm: in place of the machine's, and of those that
    /// the program names (G64 P).
    #[arg(long, value_name = "MM")]
    pub tolerance: Option<f64>,
    /// Feed of all moves but rapids, mm/s.
    #[arg(long, value_name = "MM_PER_S")]
    pub feed: Option<f64>,
    /// Servo cycle, s.
    #[arg(long, value_name = "S")]
    pub cycle: Option<f64>,
    /// Look-ahead depth, blocks (16, 64 or 256).
    #[arg(long, value_name = "BLOCKS")]
    pub lookahead: Option<usize>,
    /// Smoothing sweeps over runs of short lines (0 leaves them as they are laid).
    #[arg(long, value_name = "COUNT")]
    pub sweeps: Option<u16>,
    /// Number type of the core.
    #[arg(long, value_enum, default_value_t)]
    pub scalar: Precision,
    /// How corners are rounded.
    #[arg(long, value_enum)]
    pub mode: Option<Mode>,
    /// Share of what is left of a line that stays straight between two of its corners, in paper mode (0 to 0.99).
    #[arg(long, value_name = "SHARE")]
    pub lambda: Option<f64>,
    /// Runs a NURBS curve as so many chords of equal parameter steps, in place of the curve itself.
    #[arg(long, value_name = "COUNT")]
    pub segments: Option<usize>,
    /// Operator's commands: lines "time, action[, value]" with hold, resume, stop, abort, feed,
    /// rapid, single, starve, jog, jog-step, jog-to, jog-back, jog-cancel.
    #[arg(long, value_name = "CSV")]
    pub events: Option<PathBuf>,
    /// Setpoints, one row per servo cycle (CSV).
    #[arg(long, value_name = "CSV")]
    pub setpoints: Option<PathBuf>,
    /// Figures of the run (JSON).
    #[arg(long, value_name = "JSON")]
    pub report: Option<PathBuf>,
    /// Plot (.html, .svg or .png).
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// Prints other speed laws on the same path beside this planner; `--plot` then shows their
    /// speeds along the way.
    #[arg(long)]
    pub compare: bool,
    /// Print the figures of the run as JSON.
    #[arg(long, conflicts_with = "compare")]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// How G-code is read.
    #[command(flatten)]
    pub reading: Reading,
}

impl Simulate {
    /// The machine: description, then what the path file says, then flags.
    fn machine(&self, program: &Program) -> Result<Machine> {
        let mut machine = match &self.machine {
            Some(path) => Machine::read(path)?,
            None => Machine::default(),
        };
        if let (Some(header), None) = (&program.header, &self.machine) {
            machine.apply(header);
        }
        if let Some(tolerance) = self.tolerance {
            machine.tolerance = tolerance;
        }
        if let Some(cycle) = self.cycle {
            machine.cycle = cycle;
        }
        if let Some(mode) = self.mode {
            machine.mode = mode;
        }
        if let Some(lambda) = self.lambda {
            if machine.mode != Mode::Paper {
                bail!("--lambda {lambda}: it counts in paper mode only (--mode paper)");
            }
            machine.lambda = lambda;
        }
        if let Some(lookahead) = self.lookahead {
            machine.lookahead = lookahead;
        }
        if let Some(sweeps) = self.sweeps {
            machine.sweeps = sweeps;
        }
        Ok(machine)
    }

    /// Runs the command.
    ///
    /// # Errors
    /// What cannot be read, run or written, and limits broken by the run.
    pub fn execute(&self) -> Result<()> {
        if let Some(feed) = self.feed
            && !(feed > 0.0 && feed.is_finite())
        {
            bail!("--feed {feed}: it must be greater than 0");
        }
        self.check_files()?;
        let (program, mut found, source) = self.program()?;
        let machine = self.machine(&program)?;
        found.extend(splineway_simulator::run::validate(&program, &machine));
        if let Some(words) = sharp_corners(&program, &machine) {
            eprintln!("note: {words}");
        }
        program::refuse(&found).with_context(|| self.file.display().to_string())?;
        let events = match &self.events {
            Some(path) => Events::read(path)?,
            None => Events::default(),
        };
        let limits = machine.axes_of(&program)?;
        let letters: Vec<char> = program.axes().into_iter().map(|axis| LETTERS[axis]).collect();
        let track = Track::new(&program);
        let judge = Judge::new(&track, &limits, machine.cycle, machine.tolerance)
            .stopping(&machine.stop_axes_of(&program)?)
            .driven_by(&machine.motors_for(&program));
        let stops = Stops::new(&program, &machine)?;
        // A stop at every corner is within limits that a machine with shapers does not have.
        let judge = if machine.shaper.is_empty() { judge.timed(&stops, 0.0) } else { judge };
        let page = self.plot.as_deref().filter(|_| is_page(self.plot.as_deref()));
        let recorder = page.map(|_| recorded::recorder(&program, &machine, &track, &limits));
        let mut places = page.map(|_| Places::new(&program, &limits, machine.cycle));
        let mut watched = Watched { judge, recorder };
        let mut happenings = Happenings::new(&program);
        let mut trace = Trace::new(machine.cycle);
        let mut progress = Progress::new(track.length(), self.quiet || self.json);
        let mut csv = match &self.setpoints {
            Some(path) => Some(CsvOut::new(path, &letters, machine.motors_for(&program))?),
            None => None,
        };
        let mut observers: Vec<&mut dyn Observer> =
            vec![&mut watched, &mut progress, &mut happenings];
        if page.is_none() && self.plot.is_some() || self.compare {
            observers.push(&mut trace);
        }
        if let Some(places) = &mut places {
            observers.push(places);
        }
        if let Some(csv) = &mut csv {
            observers.push(csv);
        }
        let stats = run_with(&program, &machine, self.scalar, &events, &mut observers)
            .with_context(|| self.file.display().to_string())?;
        progress.finish();
        if let Some(csv) = csv {
            csv.finish()?;
        }
        let Watched { judge, recorder } = watched;
        let mut verdict = judge.verdict();
        if stats.aborted {
            // It was not meant to get to the end.
            verdict.end_error = 0.0;
        }
        let mut report = Report::new(&program, &machine, self.scalar, &track, &verdict, &stats);
        report.events = happenings.seen;
        if let Some(path) = &self.report {
            let text = serde_json::to_string_pretty(&report)?;
            std::fs::write(path, text)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        if let (Some(path), None, false) = (&self.plot, page, self.compare) {
            let file = self.file.file_name().unwrap_or_default().to_string_lossy();
            let (time, tolerance) = (report.time_s, machine.tolerance);
            let title = format!("{file}: {time:.3} s, tolerance {tolerance} mm");
            let (title, track, letters, limits) = (&*title, &track, &*letters, &*limits);
            plot(path, &Scene { title, track, tolerance, letters, limits, trace: &trace })?;
        }
        self.tell(&report, &stats)?;
        let mut overlays = Vec::new();
        if self.compare {
            let setting = (machine.tolerance, machine.cycle);
            overlays = self.compare(&program, &limits, setting, report.time_s, &trace)?;
        }
        let broken = violations(&verdict);
        if let (Some(path), Some(recorder), Some(places)) = (page, recorder, places) {
            let recorded = Recorded {
                file: &self.file,
                source: &source,
                program: &program,
                machine: &machine,
                track: &track,
                events: &events,
                report: &report,
                broken: &broken,
                overlays: &overlays,
            };
            recorded.write(path, recorder, places)?;
        }
        if !broken.is_empty() {
            bail!("the run broke limits: {}", broken.join("; "));
        }
        Ok(())
    }
}

impl Simulate {
    /// Prints figures and what came of probes and homing.
    fn tell(&self, report: &Report, stats: &Stats) -> Result<()> {
        if self.json {
            println!("{}", serde_json::to_string_pretty(report)?);
        } else if !self.quiet {
            print_summary(report);
            for words in &stats.sought {
                println!("{words}");
            }
            if stats.aborted {
                println!("aborted         the rest of the program was dropped");
            }
        }
        Ok(())
    }

    /// The program, with what flags put in the place of its own words; what was found in it; the lines of its file.
    fn program(&self) -> Result<(Program, Vec<Finding>, Vec<String>)> {
        let setup = setup(self.machine.as_deref())?;
        let options = ReadOptions {
            feed: self.feed.unwrap_or(DEFAULT_FEED),
            segments: self.segments,
            ..self.reading.options(&setup)
        };
        let bytes = program::bytes(&self.file)?;
        let (mut program, found) = program::inspect_bytes(&self.file, &bytes, options)?;
        if let Some(feed) = self.feed {
            for step in &mut program.moves {
                if step.speed != Speed::Rapid {
                    step.speed = Speed::PerSecond(feed);
                }
            }
        }
        super::override_tolerance(&mut program, self.tolerance);
        for warning in &program.warnings {
            eprintln!("warning: {}: {warning}", self.file.display());
        }
        let source = recorded::source(&self.file, &bytes);
        Ok((program, found, source))
    }

    /// Before anything is read or run: what is to be written can be, and is no input.
    fn check_files(&self) -> Result<()> {
        let plot = named("--plot", self.plot.as_ref());
        files::check_ending(plot, &["html", "svg", "png"])?;
        files::check(
            &[
                Some(("the program", &self.file)),
                named("--machine", self.machine.as_ref()),
                named("--events", self.events.as_ref()),
            ],
            &[
                named("--setpoints", self.setpoints.as_ref()),
                named("--report", self.report.as_ref()),
                plot,
            ],
        )
    }

    /// Other speed laws on the same path: a table, and a picture if one is wanted. Pages show them with the run.
    fn compare(
        &self,
        program: &Program,
        limits: &[Axis],
        (tolerance, cycle): (f64, f64),
        time: f64,
        trace: &Trace,
    ) -> Result<Vec<Overlay>> {
        let own = trace.points.iter().map(|point| (point.way, point.speed)).collect();
        let mut overlays = Vec::new();
        let mut curves = vec![Curve { name: format!("splineway: {time:.3} s"), points: own }];
        println!(
            "{:<46} {:>9} {:>7} {:>12} {:>14}",
            "speed law", "time, s", "ratio", "jump, mm/s", "jerk / limit"
        );
        println!("{:<46} {time:>9.3} {:>7.2} {:>12} {:>14}", "splineway", 1.0, "none", "<= 1");
        let jerk = limits.iter().map(|axis| axis.jerk).fold(f64::INFINITY, f64::min);
        for (law, name) in [
            (Law::ExactStop, "exact stop at every corner, S-curve"),
            (Law::Trapezoid, "junction deviation, trapezoid (no jerk limit)"),
            (Law::SCurve, "junction deviation, S-curve, a = 0 at corners"),
        ] {
            let outcome = baseline::run(program, limits, tolerance, law);
            println!(
                "{name:<46} {:>9.3} {:>7.2} {:>12.2} {:>14.0}",
                outcome.time,
                outcome.time / time,
                outcome.jump,
                (outcome.jump / (cycle * cycle) / jerk).max(1.0)
            );
            overlays.push(Overlay {
                name: name.to_owned(),
                time: outcome.time,
                points: outcome.curve.clone(),
            });
            curves.push(Curve {
                name: format!("{name}: {:.3} s", outcome.time),
                points: outcome.curve,
            });
        }
        println!(
            "jump: greatest step of velocity at a corner, within one servo cycle. To keep the jerk\n\
             limit there, these laws would have to stop: they become the exact stop."
        );
        if let Some(path) = self.plot.as_ref().filter(|path| !is_page(Some(path))) {
            let name = self.file.file_name().unwrap_or_default().to_string_lossy();
            plot_speeds(path, &format!("{name}: speed along the way"), &curves)?;
        }
        Ok(overlays)
    }
}

fn print_summary(report: &Report) {
    println!(
        "time            {:.3} s ({} cycles, {} blocks)",
        report.time_s, report.cycles, report.blocks
    );
    println!(
        "path length     {:.3} mm, mean speed {:.2} mm/s",
        report.path_length_mm, report.feed.mean
    );
    println!(
        "deviation       {:.6} mm (tolerance {} mm)",
        report.max_deviation_mm, report.tolerance_mm
    );
    println!("axis            velocity   acceleration   jerk   (peaks over limits)");
    for (letter, axis) in &report.axes {
        println!(
            "  {letter}             {:>8.4}   {:>12.4} {:>6.4}",
            axis.velocity.ratio, axis.acceleration.ratio, axis.jerk.ratio
        );
    }
    for (name, motor) in &report.motors {
        println!(
            "  {name:<13} {:>8.4}   {:>12.4} {:>6.4}",
            motor.velocity.ratio, motor.acceleration.ratio, motor.jerk.ratio
        );
    }
    println!(
        "cost            {:.0} ns per block planned, {:.0} ns per tick",
        report.ns_per_block.mean, report.ns_per_tick.mean
    );
    for event in &report.events {
        let pause = if event.pause { ", pause" } else { "" };
        println!(
            "event           {:.3} s, line {}: {}{pause}",
            event.time_s, event.line, event.code
        );
    }
    if report.starved > 0 {
        println!("stops for want of blocks: {}", report.starved);
    }
}
