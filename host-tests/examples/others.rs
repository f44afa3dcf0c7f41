//! Planners of others beside this one, at equal limits and in the same band, as a table; and of the first file as a picture: a
//! corner, and speed, acceleration and jerk around it. The models are written from papers by us, and are not the authors' code.
//!
//! `cargo run --release -p splineway-host --example others -- [--plot out.html] FILE...`

use anyhow::{Context, Result, ensure};
use splineway_host::view::{Drawn, Panel, Series, plot_panels};
use splineway_simulator::machine::Machine;
use splineway_simulator::program::{self, Program, ReadOptions};
use splineway_studies::others::line_path::LinePath;
use splineway_studies::others::{Planner, Run, known};
use std::path::{Path, PathBuf};

/// What of a corner is shown, in multiples of the band; a sharper turn than this is one, rad; and how near to a vertex a motion
/// has passed it, in bands (a sharp corner cuts off as much).
const AROUND: f64 = 8.0;
const SHARP: f64 = 0.5;
const PASSED: f64 = 6.0;

/// A path and what every planner makes of it.
struct Column {
    name: String,
    program: Program,
    machine: Machine,
    runs: Vec<Run>,
}

impl Column {
    fn of(file: &Path) -> Result<Self> {
        let program = program::read(file, ReadOptions { feed: 200.0, ..ReadOptions::DEFAULT })?;
        let mut machine = Machine::default();
        if let Some(header) = &program.header {
            machine.apply(header);
        }
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let run = |planner: Planner| {
            eprintln!("{name}: {}", planner.name());
            planner.run(&program, &machine).with_context(|| format!("{name}: {}", planner.name()))
        };
        let runs = Planner::ALL.into_iter().map(run).collect::<Result<_>>()?;
        Ok(Self { name, program, machine, runs })
    }
}

/// Prints the table; what the judge objects to.
fn print(columns: &[Column]) -> Vec<String> {
    let line = |first: &str, cells: Vec<String>, last: &str| {
        println!("| {first} | {} | {last} |", cells.join(" | "));
    };
    let head = columns.iter().map(|column| column.name.replace('_', ", ")).collect();
    line("planner", head, "deviation / tolerance; v, a, j / limit, at most");
    println!("|{}", "---|".repeat(columns.len() + 2));
    let mut broken = Vec::new();
    for (n, planner) in Planner::ALL.into_iter().enumerate() {
        let mut worst = [0.0f64; 4];
        for Column { name, machine, runs, .. } in columns {
            for (worst, ratio) in worst.iter_mut().zip(runs[n].ratios(machine)) {
                *worst = worst.max(ratio);
            }
            let said = |words| format!("{name}: {}: {words}", planner.name());
            broken.extend(runs[n].broken().into_iter().map(said));
        }
        let cells = columns.iter().map(|column| format!("{:.3}", column.runs[n].time())).collect();
        let [off, v, a, j] = worst;
        line(planner.name(), cells, &format!("{off:.3}; {v:.3}, {a:.3}, {j:.3}"));
    }
    let cells = |all: &[known::Known], show: fn(&known::Known) -> String| {
        let cell = |column: &Column| known::of(all, &column.name).map_or("-".to_owned(), show);
        columns.iter().map(cell).collect()
    };
    let measured = cells(&known::LINUXCNC, |known| {
        let [off, jerk] = known.ratios;
        format!("{:.2} ({off:.2}, {jerk:.2})", known.time)
    });
    line("LinuxCNC 2.10, S-curve: measured by others", measured, "in brackets: deviation, jerk");
    let least = cells(&known::ANY_MOTION, |known| format!("{:.3}", known.time));
    line("any motion in the band (local optimum)", least, "from the table of that name");
    broken
}

/// The picture of a path: its first sharp corner, and the motion up to the vertex behind.
fn panels(column: &Column) -> Result<Vec<Panel>> {
    let path = LinePath::of(&column.program, &column.machine)?;
    let corner = (0..path.lines() - 1).find(|&k| path.turn(k) > SHARP).unwrap_or(0) + 1;
    let apart = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let near = |x: &[f64]| apart(x, &path.points[corner]) <= AROUND * path.band;
    let behind = &path.points[(corner + 1).min(path.lines())];
    let passed = |run: &Run| {
        let before = run.states.iter().position(|state| near(&state[0])).unwrap_or(0);
        let there = |state: &[Vec<f64>; 3]| apart(&state[0], behind) <= PASSED * path.band;
        before + run.states[before..].iter().position(there).unwrap_or(0)
    };
    let last = column.runs.iter().map(passed).max().unwrap_or(0);
    let all = |points: &dyn Fn(&Run) -> Vec<(f64, f64)>| -> Vec<Series> {
        let series = |(planner, run): (Planner, &Run)| (planner.short().to_owned(), points(run));
        Planner::ALL.into_iter().zip(&column.runs).map(series).collect()
    };
    let place = |x: &[f64]| (x[0] - path.points[corner][0], x[1] - path.points[corner][1]);
    let traces = all(&|run| {
        let way = run.states.iter().map(|state| &state[0]).skip_while(|x| !near(x));
        way.take_while(|x| near(x)).map(|x| place(x)).collect()
    });
    let cycle = column.machine.cycle;
    let over = |value: &dyn Fn(&Run, usize) -> f64| -> Vec<Series> {
        all(&|run| {
            let shown = 1..run.states.len().min(last + 1);
            shown.map(|k| (k as f64 * cycle, value(run, k))).collect()
        })
    };
    let speed = over(&|run, k| apart(&run.states[k][1], &vec![0.0; path.limits.len()]));
    let acceleration = over(&|run, k| run.states[k][2][0]);
    let jerk = over(&|run, k| (run.states[k][2][0] - run.states[k - 1][2][0]) / cycle);
    Ok(vec![
        Panel {
            title: "the first corner: an exact stop goes along the lines".to_owned(),
            axes: ["x from the vertex, mm", "y from the vertex, mm"],
            logarithmic: false,
            drawn: Drawn::Path,
            series: traces,
        },
        Panel::over_time("speed, mm/s", speed),
        Panel::over_time("acceleration of x, mm/s2", acceleration),
        Panel::over_time("jerk of x, mm/s3", jerk),
    ])
}

fn main() -> Result<()> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let plot = words.iter().position(|word| word == "--plot");
    let out = plot.filter(|at| at + 1 < words.len()).map(|at| {
        words.remove(at);
        PathBuf::from(words.remove(at))
    });
    ensure!(!words.is_empty(), "which files?");
    let columns = words.iter().map(|file| Column::of(Path::new(file)));
    let columns: Vec<Column> = columns.collect::<Result<_>>()?;
    let broken = print(&columns);
    if let Some(out) = out {
        let title = format!("{}: planners of others, written from papers", columns[0].name);
        plot_panels(&out, &title, &panels(&columns[0])?)?;
    }
    ensure!(broken.is_empty(), "the judge objects:\n{}", broken.join("\n"));
    Ok(())
}
