//! A machine as the text of a description, with every key, its unit, and what else there could be.

use super::{LOOKAHEADS, Machine, Mode};
use std::fmt::Write as _;

/// What a machine may have besides: not read unless the `#` before it is taken away.
const FURTHER: &str = "\
#[axes.Z]              # an axis of its own; degrees for A, B, C
#velocity = 50
#acceleration = 500
#jerk = 10000

#[stop.default]        # limits of quick stops; without them as the axes' own
#acceleration = 4000   # mm/s2
#jerk = 200000         # mm/s3

#[[motor]]             # up to 8, where motors follow several axes
#name = \"left\"
#axes = { X = 1, Y = 1 } # how far for one of each
#velocity = 300        # mm/s
#acceleration = 3000   # mm/s2
#jerk = 60000          # mm/s3
#stop = { acceleration = 6000, jerk = 200000 }
#[[motor]]
#name = \"right\"
#axes = { X = 1, Y = -1 }
#velocity = 300
#acceleration = 3000
#jerk = 60000

#[shaper.default]      # input shaping: zv, mzv, ei or smooth
#kind = \"zv\"
#frequency = 45        # Hz
#damping = 0.06        # ratio

#[travel]              # least and greatest position, mm; without them an axis may go anywhere
#X = { least = 0, greatest = 400 }
#Z = { greatest = 0 }

#[work.G55]            # mm in the machine
#X = 100

#[reference.G28]       # where G28 and G30 go, mm
#Z = 50

#[tools]               # lengths for G43, mm
#1 = 75.5
";

impl Machine {
    /// The text of a description of tolerance, cycle, depths, mode and axes, as `Machine::parse` reads it back to the last bit,
    /// with examples of all other keys as comments. What else this machine has is not in it.
    pub fn describe(&self) -> String {
        let mut text = String::from(
            "# A machine for --machine. What is left out above the first table is as it stands here. An axis has all three of its limits or\n\
             # is left out: then it has those of [axes.default], if that is there.\n\n",
        );
        let mode = match self.mode {
            Mode::Band => "band",
            Mode::Paper => "paper",
        };
        let depths = LOOKAHEADS.map(|depth| depth.to_string()).join(", ");
        for (key, value, what) in [
            ("tolerance", number(self.tolerance), "mm, of moves that name none (G64 P)"),
            ("cycle", number(self.cycle), "s, servo cycle"),
            ("lookahead", self.lookahead.to_string(), &*format!("blocks: {depths}")),
            (
                "sweeps",
                self.sweeps.to_string(),
                "smoothing of runs of short lines; 0 leaves them as they are laid",
            ),
            (
                "reshape",
                self.reshape.to_string(),
                "whether shape and speed of the motion are improved together",
            ),
            (
                "mode",
                format!("\"{mode}\""),
                "corners of lines: \"band\", or \"paper\" as in Guo, Yan, Wang 2023",
            ),
            (
                "lambda",
                number(self.lambda),
                "of the paper's: share of what is left of a line that stays straight between two corners, 0 to 0.99",
            ),
            ("lead", number(self.lead), "s, by which a plan is handed over before it takes effect"),
        ] {
            let _ = writeln!(text, "{:<22} # {what}", format!("{key} = {value}"));
        }
        text.push_str(
            "#switches = [\"X>5\", \"Z>2\"] # where home switches are closed, mm, as coordinates are when the machine is switched on\n\
             #surfaces = [\"Z<-20\"]  # where the probe is closed, mm\n\n",
        );
        for (name, axis) in &self.axes {
            let _ = writeln!(text, "[axes.{name}]");
            for (key, value, unit) in [
                ("velocity", axis.velocity, "mm/s"),
                ("acceleration", axis.acceleration, "mm/s2"),
                ("jerk", axis.jerk, "mm/s3"),
            ] {
                let _ = writeln!(text, "{:<22} # {unit}", format!("{key} = {}", number(value)));
            }
            text.push('\n');
        }
        text + FURTHER
    }
}

/// The shortest digits that are read back as the same number, without an exponent where that is plain.
fn number(x: f64) -> String {
    if x == 0.0 || (1.0e-6..1.0e9).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Axis;

    #[test]
    fn it_is_read_back_to_the_last_bit() {
        let mut machine = Machine::default();
        assert_eq!(Machine::parse(&machine.describe()).unwrap(), machine);
        machine.tolerance = 1.0 / 3.0;
        machine.cycle = 1.0e-3 / 3.0;
        machine.mode = Mode::Paper;
        machine.lambda = 0.1 + 0.2;
        machine.axes.insert(
            "Z".to_owned(),
            Axis { velocity: 100.0 / 3.0, acceleration: 1.0e-3 / 7.0, jerk: 1.0e7 / 3.0 },
        );
        assert_eq!(Machine::parse(&machine.describe()).unwrap(), machine);
    }

    /// The examples of other keys can be used as they stand, all at once, and every key of a machine is named.
    #[test]
    fn the_comments_are_a_machine_too() {
        let text = Machine::default().describe();
        let open = |line: &str| {
            let key = line.strip_prefix('#').filter(|rest| !rest.starts_with(' '));
            key.unwrap_or(line).to_owned() + "\n"
        };
        let text: String = text.lines().map(open).collect();
        let machine = Machine::parse(&text).unwrap();
        assert!(!machine.motor.is_empty() && !machine.stop.is_empty() && !machine.tools.is_empty());
        assert!(
            !machine.shaper.is_empty() && !machine.travel.is_empty() && !machine.work.is_empty()
        );
        assert!(!machine.reference.is_empty() && !machine.switches.is_empty());
        assert!(!machine.surfaces.is_empty() && machine.axes.len() == 2);
    }
}
