//! `splineway formats`: what the program reads and writes.

use anyhow::Result;
use splineway_simulator::program::KINDS;
use splineway_simulator::run::FORMAT;

/// Lists the files that are read and written: programs, machines, operator's commands, setpoints, reports
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Formats {}

impl Formats {
    /// Runs the command.
    ///
    /// # Errors
    /// None.
    pub fn execute(&self) -> Result<()> {
        println!("Programs, by the ending of the file (of standard input, -, by what is in it):");
        for (_, endings, what) in KINDS {
            println!("  .{:<42} {what}", endings.join(" ."));
        }
        println!("{PROGRAMS}\n\nOperator's commands (--events):\n{FORMAT}\n\n{OUTPUTS}");
        Ok(())
    }
}

/// What is in them.
const PROGRAMS: &str = "
G-code: `splineway gcodes` lists the codes that are read.

Poly-line, mm and mm/s; the first point is the start:
  # VELOCITY ACCELERATION JERK TOLERANCE CYCLE     (mm/s, mm/s2, mm/s3, mm, s; may be left out)
  X Y Z FEED                                       (a line for each point)

Spline, cubic unless a degree is given, open or closed; JSON and TOML have the same members:
  control_points = [[0, 0], [1, 2], ...]           mm, two or three coordinates each
  knots = [0, 0, 0, 0, 1, ...]                     of a closed spline its intervals
  degree, weights, closed, tolerance (mm), precision, accuracy, feed (mm/s), name
As text, an item a line:
  point X Y [Z] | knots K ... | intervals K ... | tolerance R | precision N | accuracy A | feed F | closed

Machine (--machine, TOML): `splineway machine` prints one to begin with.";

/// What is written.
const OUTPUTS: &str = "\
Setpoints (--setpoints, CSV): t (s), then x,y,z and the other axes in use (mm, degrees), then motors by their names (mm); a row for
  every servo cycle, 15 significant digits.
Figures (--json, --report, JSON): units are in the names: _s, _mm, _mm_s, _mm_s2, _mm_s3, _deg, _share (of 1), ratio (over a limit).
Plots (--plot): .html (a page that stands alone), .svg, .png.";
