//! G-code with probes, homing and outputs, sent by `splineway stream` to `splineway controller`: as processes, over a pseudo-terminal.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdout, Command, Output, Stdio};

const PROGRAM: &str = env!("CARGO_BIN_EXE_splineway");

/// A controller without a machine, which ends with the test.
struct Controller {
    child: Child,
    lines: std::io::Lines<BufReader<ChildStdout>>,
    port: String,
}

impl Controller {
    fn new(options: &[&str]) -> Self {
        let mut child = Command::new(PROGRAM)
            .args(["controller", "--speed", "10"])
            .args(options)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let first = lines.next().unwrap().unwrap();
        let port = first.strip_prefix("port: ").unwrap().to_owned();
        Self { child, lines, port }
    }

    /// Sends a program from a file.
    fn send(&self, text: &str, options: &[&str]) -> Output {
        let mut file = tempfile();
        file.1.write_all(text.as_bytes()).unwrap();
        let output = Command::new(PROGRAM)
            .arg("stream")
            .arg(&file.0)
            .args(["--port", &self.port, "--watchdog", "30", "--json"])
            .args(options)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        std::fs::remove_file(&file.0).unwrap();
        output
    }

    /// What it has told, up to the end of a program at this place.
    fn told(&mut self, place: &str) -> Vec<String> {
        let mut told = Vec::new();
        for line in self.lines.by_ref().map_while(Result::ok) {
            let ends = line.starts_with("program run") && line.contains(place);
            told.push(line);
            if ends {
                break;
            }
        }
        told
    }
}

impl Drop for Controller {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A file of its own for G-code.
fn tempfile() -> (std::path::PathBuf, std::fs::File) {
    use std::sync::atomic::{AtomicU32, Ordering};
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let name = format!("splineway-{}-{number}.ngc", std::process::id());
    let path = std::env::temp_dir().join(name);
    let file = std::fs::File::create(&path).unwrap();
    (path, file)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

const HOME: &str = "X20 Y20 slow 4 reach 30 back 1 at 0 park -2";

/// The position of an axis in the report.
fn position(output: &Output, axis: &str) -> f64 {
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    report["position"][axis].as_f64().unwrap()
}

#[test]
fn what_follows_a_probe_begins_where_the_machine_then_stands() {
    let program = "\
G21 G90
$H
G0 X-30 Y-30
M62 P0
G1 X-20 F3000
G38.2 Z-20 F600
G92 Z0
G0 Z2
M4 S500
G1 X-15 F3000
M5
M64 P1
G1 X-10
M67 E1 Q2.5
G1 X-11
M2
";
    for faults in ["0", "0.002"] {
        let mut controller = Controller::new(&[
            "--switch",
            "X>12",
            "--switch",
            "Y>9",
            "--surface",
            "Z<-5",
            "--faults",
            faults,
        ]);
        let sent = controller.send(program, &["--home", HOME, "--outputs", "--laser", "1000"]);
        let errors = text(&sent.stderr);
        assert!(sent.status.success(), "{errors}");
        assert!(errors.contains("line 2: homed; the machine rests at X-2.000 Y-2.000"), "{errors}");
        assert!(
            errors.contains("line 6: the probe: contact at X-20.000 Y-30.000 Z-5.000"),
            "{errors}"
        );
        let [x, y, z] = ["X_mm", "Y_mm", "Z_mm"].map(|axis| position(&sent, axis));
        assert!((x + 11.0).abs() < 1.0e-6 && (y + 30.0).abs() < 1.0e-6, "{x} {y}");
        // 2 mm above where the probe came to rest, a little below the surface.
        assert!(z < -3.0 && z > -3.2, "{z}");
        let told = controller.told("X-11.0");
        let outputs: Vec<&str> = told
            .iter()
            .map(String::as_str)
            .filter(|line| line.contains("output") || line.contains("laser"))
            .collect();
        // M64 is at rest, where the laser does not burn: both in one servo cycle.
        let wanted =
            ["output 0 on", "laser burns", "output 1 on", "laser off", "analogue output 1 at 2.5"];
        assert_eq!(outputs.len(), wanted.len(), "{told:?}");
        assert!(
            outputs.iter().zip(wanted).all(|(seen, wanted)| seen.starts_with(wanted)),
            "{outputs:?}"
        );
    }
}

#[test]
fn what_is_not_found_ends_the_program() {
    let mut controller = Controller::new(&["--switch", "X>12"]);
    let sent = controller.send("G38.2 Z-3 F600\nG0 X5\nM2\n", &[]);
    let errors = text(&sent.stderr);
    assert!(!sent.status.success() && errors.contains("line 1: the probe: no contact"), "{errors}");
    // A probe that need not have contact goes on.
    let sent = controller.send("G38.3 Z-4 F600\nG0 X5\nM2\n", &[]);
    let errors = text(&sent.stderr);
    assert!(sent.status.success() && errors.contains("no contact at"), "{errors}");
    assert!((position(&sent, "X_mm") - 5.0).abs() < 1.0e-6);
    controller.told("X5.0");
    // Y has no switch.
    let sent = controller.send("$H\nM2\n", &["--home", HOME]);
    let errors = text(&sent.stderr);
    assert!(
        !sent.status.success() && errors.contains("homing, Y: the switch does not close"),
        "{errors}"
    );
    let sent = controller.send("G0 X1\n$H\nM2\n", &[]);
    let errors = text(&sent.stderr);
    assert!(
        !sent.status.success() && errors.contains("nothing says how the axes are homed"),
        "{errors}"
    );
}
