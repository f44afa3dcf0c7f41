//! `splineway corners`: corner transitions of the literature beside this core's.

use super::numbers::{above_zero, between};
use crate::view::Busy;
use anyhow::Result;
use serde::Serialize;
use splineway_simulator::machine::Machine;
use splineway_studies::corners::{Continuity, table};
use std::path::PathBuf;

/// Compares corner transitions at equal deviation: smoothness, time, effort
#[derive(Clone, Debug, clap::Args)]
pub struct Corners {
    /// True deviation of every transition from the corner's legs, mm, up to 0.2
    #[arg(long, value_name = "MM", default_value_t = 0.05, value_parser = above_zero(0.2, "mm"))]
    pub tolerance: f64,
    /// Turns, 15 to 155 degrees, with commas between: 30,60
    #[arg(long, value_name = "DEGREES", value_delimiter = ',', value_parser = between(15.0, 155.0, "degrees"),
        default_values_t = [30.0, 60.0, 90.0, 120.0, 150.0])]
    pub turns: Vec<f64>,
    /// Machine description (TOML), whose default axis counts [default: a small milling machine, which `splineway machine` prints]
    #[arg(long, value_name = "TOML")]
    pub machine: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// A transition, as JSON.
#[derive(Serialize)]
struct Figures {
    turn_deg: f64,
    deviation_mm: f64,
    method: &'static str,
    /// Whether the construction had to be derived, because it is not printed.
    derived: bool,
    continuity: String,
    peak_curvature_per_mm: f64,
    /// None where the curvature jumps.
    third_derivative_per_mm2: Option<f64>,
    leg_s: f64,
    /// What it takes to work it out.
    operations: String,
}

impl Corners {
    /// Runs the command.
    ///
    /// # Errors
    /// Values out of range, a machine that cannot be read, a speed law that cannot be solved.
    pub fn execute(&self) -> Result<()> {
        let machine = match &self.machine {
            Some(path) => Machine::read(path)?,
            None => Machine::default(),
        };
        let mut all = Vec::new();
        for &turn in &self.turns {
            let busy = Busy::new(format!("turn of {turn} degrees"), false);
            let rows = table(turn, self.tolerance, &machine)?;
            drop(busy);
            if self.json {
                all.extend(rows.iter().map(|row| Figures {
                    turn_deg: turn,
                    deviation_mm: self.tolerance,
                    method: row.method.name,
                    derived: row.method.derived,
                    continuity: format!("{:?}", row.method.continuity),
                    peak_curvature_per_mm: row.curvature,
                    third_derivative_per_mm2: row.third.is_finite().then_some(row.third),
                    leg_s: row.time,
                    operations: (row.method.cost)(turn.to_radians()).to_string(),
                }));
                continue;
            }
            println!("turn {turn} degrees, deviation {} mm, legs of 10 mm", self.tolerance);
            println!(
                "  {:<42} {:<5} {:>11} {:>14} {:>11}  operations",
                "method (* derived)", "", "peak, 1/mm", "third, 1/mm2", "s per leg"
            );
            for row in rows {
                let mark = if row.method.derived { " *" } else { "" };
                let continuity = match row.method.continuity {
                    Continuity::G1 => "G1",
                    Continuity::G2 => "G2",
                    Continuity::G3 => "G3",
                };
                println!(
                    "  {:<42} {continuity:<5} {:>11.3} {:>14.2} {:>11.4}  {}",
                    format!("{}{mark}", row.method.name),
                    row.curvature,
                    row.third,
                    row.time,
                    (row.method.cost)(turn.to_radians())
                );
            }
        }
        if self.json {
            println!("{}", serde_json::to_string_pretty(&all)?);
        }
        Ok(())
    }
}
