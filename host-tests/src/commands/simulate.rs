//! `splineway simulate`: a file through the core, cycle by cycle.

use super::files::{self, named};
use super::numbers::{Usage, one_of, setting, whole};
use super::page;
use super::reading::Reading;
use super::recorded::{self, Places, Recorded, is_page};
use crate::view::page::Overlay;
use crate::view::{Busy, Curve, Progress, Scene, plot, plot_speeds};
use anyhow::{Context, Result, bail, ensure};
use splineway::machine::Quantity;
use splineway_simulator::judge::{Judge, Track, violations};
use splineway_simulator::machine::{Axis, LOOKAHEADS, Machine, Mode, is_rotary};
use splineway_simulator::program::{self, LETTERS, Loaded, ReadOptions, Tape};
use splineway_simulator::record::recording::Watched;
use splineway_simulator::record::{CsvOut, Report, Trace};
use splineway_simulator::run::{
    Events, Happenings, Observer, Precision, Stats, Stops, run_with, sharp_corners,
};
use splineway_studies::baseline::{self, Law};
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  splineway simulate part.ngc --open
  splineway simulate host-tests/data/butterfly.json --tolerance 0.05 --plot butterfly.html
  splineway simulate part.gcode --machine mill.toml --report part.json
  splineway simulate path.txt --scalar f32 --setpoints setpoints.csv

Exit codes: 0 done, 1 error, a limit broken, or a probe or homing that found nothing or was cancelled, 2 wrong usage.";

/// Runs a tool path through the motion core and judges every servo cycle
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Simulate {
    /// G-code (.ngc .nc .gcode .tap ...), poly-line (.txt), spline (.toml) or curve (.json); "-" is standard input: see `splineway formats`
    pub file: PathBuf,
    /// How the program is read, and the machine.
    #[command(flatten)]
    pub reading: Reading,
    /// Greatest distance from the programmed path, mm, in place of the machine's, and of those that the program names (G64 P)
    /// [default: those]
    #[arg(long, value_name = "MM", value_parser = setting(Quantity::Tolerance, "mm"))]
    pub tolerance: Option<f64>,
    /// Servo cycle, s [default: the machine's]
    #[arg(long, value_name = "S", value_parser = setting(Quantity::Cycle, "s"))]
    pub cycle: Option<f64>,
    /// Look-ahead depth, blocks: 16, 64 or 256 [default: the machine's]
    #[arg(long, value_name = "BLOCKS", value_parser = one_of(&LOOKAHEADS))]
    pub lookahead: Option<usize>,
    /// Smoothing sweeps over runs of short lines; 0 leaves them as they are laid [default: the machine's]
    #[arg(long, value_name = "COUNT", value_parser = whole(0_u16, 100))]
    pub sweeps: Option<u16>,
    /// Improves shape and speed of the motion together, inside the band [default: the machine's]
    #[arg(long)]
    pub reshape: bool,
    /// Number type of the core
    #[arg(long, value_enum, default_value_t)]
    pub scalar: Precision,
    /// How corners are rounded [default: the machine's]
    #[arg(long, value_enum)]
    pub mode: Option<Mode>,
    /// Share of what is left of a line that stays straight between two of its corners, in paper mode, 0 to 0.99 [default: the
    /// machine's]
    #[arg(long, value_name = "SHARE", value_parser = setting(Quantity::Lambda, ""))]
    pub lambda: Option<f64>,
    /// Runs a NURBS curve as so many chords of equal parameter steps [default: as the curve itself]
    #[arg(long, value_name = "COUNT", value_parser = whole(1_usize, 1_000_000))]
    pub segments: Option<usize>,
    /// Operator's commands: lines "time, action[, value]"; `splineway formats` lists the actions [default: none]
    #[arg(long, value_name = "CSV")]
    pub events: Option<PathBuf>,
    /// Writes setpoints, one row per servo cycle (CSV) [default: not written]
    #[arg(long, value_name = "CSV")]
    pub setpoints: Option<PathBuf>,
    /// Writes figures of the run (JSON) [default: not written]
    #[arg(long, value_name = "JSON")]
    pub report: Option<PathBuf>,
    /// Writes a plot (.html, .svg or .png) [default: not written]
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// Opens the plot; if --plot does not say where it goes, a page in the folder for temporary files
    #[arg(long)]
    pub open: bool,
    /// Prints other speed laws on the same path beside this planner; the plot then shows their speeds along the way
    #[arg(long)]
    pub compare: bool,
    /// Print the figures of the run as JSON
    #[arg(long, conflicts_with = "compare")]
    pub json: bool,
    /// Print nothing but errors
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
}

/// What is to be run.
#[derive(Clone, Copy)]
struct Job<'a> {
    /// Its text, if it has lines to speak of.
    source: &'a [u8],
    program: &'a dyn Tape,
    machine: &'a Machine,
    events: &'a Events,
}

impl Simulate {
    /// The machine: description, then what the path file says, then flags.
    fn machine(&self, mut machine: Machine, program: &dyn Tape) -> Result<Machine> {
        self.reading.apply_header(program, &mut machine);
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
                let words = "it counts in paper mode only (--mode paper)";
                return Err(Usage::error(format!("--lambda {lambda}: {words}")));
            }
            machine.lambda = lambda;
        }
        if let Some(lookahead) = self.lookahead {
            machine.lookahead = lookahead;
        }
        if let Some(sweeps) = self.sweeps {
            machine.sweeps = sweeps;
        }
        machine.reshape |= self.reshape;
        ensure!(
            !(machine.reshape && machine.mode == Mode::Paper),
            "reshape: in paper mode the corners are those of the paper, and stay so"
        );
        Ok(machine)
    }

    /// Runs the command.
    ///
    /// # Errors
    /// What cannot be read, run or written, and limits broken by the run.
    pub fn execute(&self) -> Result<()> {
        let plotted = self.plot.clone().or_else(|| self.open.then(|| page::place(&self.file)));
        self.check_files(plotted.as_ref())?;
        let machine = self.reading.machine()?;
        let busy = Busy::new(format!("reading {}", self.file.display()), self.quiet);
        let setup = machine.setup();
        let options = ReadOptions { segments: self.segments, ..self.reading.options(&setup) };
        let file = Loaded::new(&self.file)?;
        let (program, mut found) = file.program(options)?;
        let program = &self.reading.overriding(&*program, self.tolerance);
        for warning in program.warnings() {
            eprintln!("warning: {}: {warning}", self.file.display());
        }
        let machine = self.machine(machine, program)?;
        if let Some(name) = &self.reading.machine {
            machine.axes_of(program).with_context(|| name.display().to_string())?;
        }
        found.extend(splineway_simulator::run::validate(program, &machine));
        if let Some(words) = sharp_corners(program, &machine) {
            eprintln!("note: {words}");
        }
        let plain =
            machine.motor.is_empty() && machine.travel.is_empty() && machine.shaper.is_empty();
        if machine.reshape && (!plain || program.axes().into_iter().any(is_rotary)) {
            eprintln!(
                "note: reshape gains nothing with rotary axes, motors that follow several axes, limits of travel or shapers"
            );
        }
        program::refuse(&found).with_context(|| self.file.display().to_string())?;
        let events = match &self.events {
            Some(path) => Events::read(path)?,
            None => Events::default(),
        };
        let job = Job { source: file.lines(), program, machine: &machine, events: &events };
        self.run(&job, plotted.as_deref(), busy)
    }

    /// Runs what was read.
    fn run(&self, job: &Job<'_>, plotted: Option<&Path>, busy: Busy) -> Result<()> {
        let Job { program, machine, events, .. } = *job;
        let limits = machine.axes_of(program)?;
        let letters: Vec<char> = program.axes().into_iter().map(|axis| LETTERS[axis]).collect();
        // All of the path is looked at for a plot only; else it takes no room.
        let track = plotted.is_some().then(|| Track::of(program));
        let judge = Judge::passing(program, &limits, machine.cycle, machine.tolerance)
            .stopping(&machine.stop_axes_of(program)?)
            .driven_by(&machine.motors_for(program));
        let stops = Stops::passing(program, machine)?;
        // A stop at every corner is within limits that a machine with shapers does not have.
        let judge = if machine.shaper.is_empty() { judge.timed(&stops, 0.0) } else { judge };
        let page = plotted.filter(|path| is_page(path));
        let recorder = page.and(track.as_ref());
        let recorder = recorder.map(|track| recorded::recorder(program, machine, track, &limits));
        let mut places = page.map(|_| Places::new(program, machine, &limits)).transpose()?;
        drop(busy);
        let mut watched = Watched { judge, recorder };
        let mut happenings = Happenings::new(program);
        let mut trace = Trace::new(machine.cycle);
        let last = program.summary().last_line;
        let mut progress = Progress::over_lines(last, self.quiet);
        let mut csv = match &self.setpoints {
            Some(path) => Some(CsvOut::new(path, &letters, machine.motors_for(program))?),
            None => None,
        };
        let mut observers: Vec<&mut dyn Observer> =
            vec![&mut watched, &mut progress, &mut happenings];
        if page.is_none() && plotted.is_some() || self.compare {
            observers.push(&mut trace);
        }
        if let Some(places) = &mut places {
            observers.push(places);
        }
        if let Some(csv) = &mut csv {
            observers.push(csv);
        }
        let stats = run_with(program, machine, self.scalar, events, &mut observers)
            .with_context(|| self.file.display().to_string())?;
        progress.finish();
        if let Some(csv) = csv {
            csv.finish()?;
        }
        let Watched { mut judge, recorder } = watched;
        let mut verdict = judge.verdict();
        if stats.aborted {
            // It was not meant to get to the end.
            verdict.end_error = 0.0;
        }
        let mut report =
            Report::new(program, machine, self.scalar, judge.length(), &verdict, &stats);
        report.events = happenings.seen;
        self.write(&report)?;
        if let (Some(path), Some(track), None, false) = (plotted, &track, page, self.compare) {
            let _busy = Busy::new("drawing", self.quiet);
            let file = self.file.file_name().unwrap_or_default().to_string_lossy();
            let (time, tolerance) = (report.time_s, machine.tolerance);
            let title = format!("{file}: {time:.3} s, tolerance {tolerance} mm");
            let (title, letters, limits) = (&*title, &*letters, &*limits);
            plot(path, &Scene { title, track, tolerance, letters, limits, trace: &trace })?;
        }
        self.tell(&report, &stats)?;
        let mut overlays = Vec::new();
        if self.compare {
            overlays = self.compare(job, &limits, report.time_s, &trace, plotted)?;
        }
        let broken = violations(&verdict);
        if let (Some(path), Some(track), Some(recorder), Some(places)) =
            (page, &track, recorder, places)
        {
            let _busy = Busy::new("drawing", self.quiet);
            let (file, report, broken, overlays) = (&*self.file, &report, &*broken, &*overlays);
            let Job { source, .. } = *job;
            Recorded { file, source, program, machine, track, events, report, broken, overlays }
                .write(path, recorder, places)?;
        }
        self.show(plotted)?;
        if !broken.is_empty() {
            bail!("the run broke limits: {}", broken.join("; "));
        }
        if stats.sought.iter().any(|sought| !sought.is_found()) {
            let words: Vec<String> = stats.sought.iter().map(ToString::to_string).collect();
            bail!("not found: {}", words.join("; "));
        }
        Ok(())
    }
}

impl Simulate {
    /// Writes the report, if it is wanted.
    fn write(&self, report: &Report) -> Result<()> {
        if let Some(path) = &self.report {
            let text = serde_json::to_string_pretty(&report)?;
            std::fs::write(path, text)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        Ok(())
    }

    /// Says what came of it.
    fn tell(&self, report: &Report, stats: &Stats) -> Result<()> {
        if let (Some(first), count) = (stats.unplayed.first(), stats.unplayed.len()) {
            let end = report.time_s;
            eprintln!(
                "warning: the run ends at {end:.3} s: {count} of the events come too late, the first at {first} s"
            );
        }
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

    /// Opens the plot, if that is wanted.
    fn show(&self, plotted: Option<&Path>) -> Result<()> {
        if let (Some(page), true) = (plotted, self.open) {
            if !(self.quiet || self.json) {
                println!("page            {}", page.display());
            }
            page::show(page)?;
        }
        Ok(())
    }

    /// Before anything is read or run: what is to be written can be, and is no input.
    fn check_files(&self, plotted: Option<&PathBuf>) -> Result<()> {
        let plot = named("--plot", plotted);
        files::check_ending(plot, &["html", "svg", "png"])?;
        files::check(
            &[
                Some(("the program", &self.file)),
                self.reading.file(),
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
        job: &Job<'_>,
        limits: &[Axis],
        time: f64,
        trace: &Trace,
        plotted: Option<&Path>,
    ) -> Result<Vec<Overlay>> {
        let (tolerance, cycle) = (job.machine.tolerance, job.machine.cycle);
        let program = &job.program.to_program();
        let mut overlays = Vec::new();
        let own = trace.points.iter().map(|point| (point.way, point.speed)).collect();
        let mut curves = vec![Curve { name: format!("splineway: {time:.3} s"), points: own }];
        let say = |text: std::fmt::Arguments<'_>| {
            if !self.quiet {
                println!("{text}");
            }
        };
        say(format_args!(
            "{:<46} {:>9} {:>7} {:>12} {:>14}",
            "speed law", "time, s", "ratio", "jump, mm/s", "jerk / limit"
        ));
        say(format_args!(
            "{:<46} {time:>9.3} {:>7.2} {:>12} {:>14}",
            "splineway", 1.0, "none", "<= 1"
        ));
        let jerk = limits.iter().map(|axis| axis.jerk).fold(f64::INFINITY, f64::min);
        for (law, name) in [
            (Law::ExactStop, "exact stop at every corner, S-curve"),
            (Law::Trapezoid, "junction deviation, trapezoid (no jerk limit)"),
            (Law::SCurve, "junction deviation, S-curve, a = 0 at corners"),
        ] {
            let outcome = baseline::run(program, limits, tolerance, law);
            say(format_args!(
                "{name:<46} {:>9.3} {:>7.2} {:>12.2} {:>14.0}",
                outcome.time,
                outcome.time / time,
                outcome.jump,
                (outcome.jump / (cycle * cycle) / jerk).max(1.0)
            ));
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
        say(format_args!(
            "jump: greatest step of velocity at a corner, within one servo cycle. To keep the jerk\n\
             limit there, these laws would have to stop: they become the exact stop."
        ));
        if let Some(path) = plotted.filter(|path| !is_page(path)) {
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
        report.path_length_mm, report.feed.mean_mm_s
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
