//! The page of a run: what it shows is what was run. By what is written of it here, and by the page's own scripts where node is.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use serde_json::Value;
use splineway_simulator::machine::Axis;
use splineway_simulator::record::recording::{Column, Grain, Numbers, Tape};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Command;

fn folder() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
}

fn data(name: &str) -> String {
    format!("{}/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A file of its own for each test.
fn file(name: &str, text: &str) -> String {
    let path = folder().join(name);
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}

/// A page, and the setpoints of the same run.
struct Written {
    page: PathBuf,
    setpoints: PathBuf,
    text: String,
}

fn simulate(name: &str, program: &str, more: &[&str]) -> Written {
    let (page, setpoints) =
        (folder().join(format!("{name}.html")), folder().join(format!("{name}.csv")));
    let output = Command::new(env!("CARGO_BIN_EXE_splineway"))
        .args(["simulate", program, "--plot"])
        .arg(&page)
        .arg("--setpoints")
        .arg(&setpoints)
        .args(more)
        .output()
        .unwrap();
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&page).unwrap();
    Written { page, setpoints, text }
}

impl Written {
    /// What is between the tags of a part.
    fn part(&self, id: &str) -> &str {
        let begin = self.text.find(&format!("id=\"{id}\">")).unwrap() + id.len() + "id=\"\">".len();
        let length = self.text[begin..].find("</script>").unwrap();
        &self.text[begin..begin + length]
    }

    fn head(&self) -> Value {
        serde_json::from_str(self.part("head")).unwrap()
    }

    fn unpacked(&self, id: &str) -> Vec<u8> {
        let packed = STANDARD.decode(self.part(id)).unwrap();
        let mut bytes = Vec::new();
        ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
        bytes
    }

    /// What is written of the axes, as the simulator reads it, against the setpoints.
    fn decodes(&self, tolerance: f64) {
        let (head, body) = (self.head(), self.unpacked("body"));
        let number = |value: &Value| value.as_f64().unwrap();
        let axes = head["axes"].as_array().unwrap();
        let any = Axis { velocity: 1.0, acceleration: 1.0, jerk: 1.0 };
        let mut grain = Grain::new(number(&head["cycle"]), 1.0, &vec![any; axes.len()]);
        grain.position = number(&head["count"]);
        let mut start = Vec::new();
        for (unit, axis) in grain.axes.iter_mut().zip(axes) {
            unit.velocity = number(&axis["counts"][0]);
            unit.acceleration = number(&axis["counts"][1]);
            start.push([0, 1, 2].map(|k| axis["start"][k].as_i64().unwrap()));
        }
        let mut rest = &body[..];
        let mut columns = Vec::new();
        for entry in head["columns"].as_array().unwrap() {
            let (column, others) = rest.split_at(entry[1].as_u64().unwrap() as usize);
            rest = others;
            if entry[0].as_str().unwrap().starts_with("tape") {
                columns.push(Column::from(column.to_vec()));
            }
        }
        assert!(rest.is_empty());
        let text = std::fs::read_to_string(&self.setpoints).unwrap();
        let mut rows = text.lines().skip(1);
        let mut worst = 0.0f64;
        Tape::of(grain, start, columns).play(&mut |states, _| {
            let row = rows.next().unwrap().split(',').skip(1).map(|x| x.parse::<f64>().unwrap());
            let off = states.iter().zip(row).map(|(state, x)| (state[0] - x).powi(2));
            worst = worst.max(off.sum::<f64>().sqrt());
        });
        assert!(rows.next().is_none());
        assert!(worst <= (0.1 * tolerance).max(1e-6), "{worst} mm off");
        assert!(worst <= number(&head["off"]), "{worst} mm off, and the page says {}", head["off"]);
    }

    /// The same, and much more, by the page's own scripts, where node is.
    fn holds(&self, tolerance: f64, overlays: usize) {
        self.decodes(tolerance);
        let (page, setpoints) =
            (self.page.display().to_string(), self.setpoints.display().to_string());
        node("run.mjs", &[&page, &setpoints, &tolerance.to_string()], overlays);
    }
}

/// Runs a script of `tests/page`.
fn node(script: &str, arguments: &[&str], overlays: usize) {
    let script = format!("{}/tests/page/{script}", env!("CARGO_MANIFEST_DIR"));
    match Command::new("node")
        .arg(script)
        .args(arguments)
        .env("OVERLAYS", overlays.to_string())
        .output()
    {
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stdout);
            assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
            assert!(text.contains("# fail 0") && !text.contains("# pass 0"), "no test ran: {text}");
        }
        Err(error) => eprintln!("skipped: the page's scripts need node 20 ({error})"),
    }
}

#[test]
fn the_scripts_compute_right() {
    node("pure.mjs", &[], 0);
}

#[test]
fn a_curve_and_its_setpoints() {
    let page = simulate(
        "page-butterfly",
        &data("butterfly.json"),
        &["--tolerance", "0.05", "--feed", "200"],
    );
    assert!(!page.text.contains("{{") && !page.text.contains("http"), "the page must stand alone");
    page.holds(0.05, 0);
}

#[test]
fn lines_are_beside_the_run_and_other_laws_on_top() {
    let page = simulate("page-square", &data("square.ngc"), &["--compare"]);
    let source = String::from_utf8(page.unpacked("source")).unwrap();
    let file = std::fs::read_to_string(data("square.ngc")).unwrap();
    assert_eq!(source.lines().next(), file.lines().next());
    assert_eq!(source.lines().count(), file.lines().count());
    assert_eq!(page.head()["overlays"].as_array().unwrap().len(), 3);
    assert!(!page.head()["slow"].as_array().unwrap().is_empty());
    page.holds(page.head()["tolerance"].as_f64().unwrap(), 3);
}

#[test]
fn no_motion_one_move_and_events() {
    let none = simulate("page-none", &file("page-none.ngc", "G21 G90\nM2\n"), &[]);
    assert_eq!(none.head()["slow"].as_array().unwrap().len(), 0);
    none.holds(0.01, 0);
    let one = simulate("page-one", &file("page-one.ngc", "G1 X0.001 F60\n"), &["--tolerance", "0"]);
    one.holds(0.0, 0);
    let text = "M3 S1000\nG1 X10 F6000 (</script><!-- & -->)\nG4 P0.1\nM0\nM5\nG0 X0\n";
    let commands = file("page-commands.csv", "0.05,hold\n0.2,feed,50\n0.3,resume\n");
    let events = simulate("page-events", &file("page-events.ngc", text), &["--events", &commands]);
    let head = events.head();
    let codes: Vec<&str> = head["events"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|event| event["text"].as_str())
        .collect();
    assert_eq!(codes.len(), 3, "{codes:?}");
    assert!(codes[1].contains("M0") && codes[1].contains("pause"), "{codes:?}");
    assert_eq!(head["commands"][1]["text"], "feed 50 %");
    assert!(String::from_utf8(events.unpacked("source")).unwrap().contains("</script><!-- & -->"));
    events.holds(head["tolerance"].as_f64().unwrap(), 0);
}

#[test]
fn nine_axes_and_rotary_ones() {
    let nine = "G1 X1 Y2 Z3 A4 B5 C6 U7 V8 W9 F600\nX0 Y0 Z0 A0 B0 C0 U0 V0 W0\n";
    let page = simulate("page-nine", &file("page-nine.ngc", nine), &["--tolerance", "0.01"]);
    let head = page.head();
    let axes = head["axes"].as_array().unwrap();
    assert_eq!(axes.len(), 9);
    assert_eq!(axes.iter().filter(|axis| axis["rotary"] == true).count(), 3);
    page.holds(0.01, 0);
    let turn = simulate(
        "page-rotary",
        &file("page-rotary.ngc", "G1 A360 F3600\nA0\n"),
        &["--tolerance", "0.01"],
    );
    turn.holds(0.01, 0);
    let belts = simulate("page-corexy", &data("square.ngc"), &["--machine", &data("corexy.toml")]);
    assert_eq!(belts.head()["motors"].as_array().unwrap().len(), 2);
    belts.holds(belts.head()["tolerance"].as_f64().unwrap(), 0);
}

/// What is asked for is written cycle by cycle: a line that drills has a feed for each of its moves.
#[test]
fn feeds_are_those_of_the_moves() {
    let text = "G21 G90\nG0 Z5\nG81 X10 Y0 Z-20 R2 F600\nG80\nM2\n";
    let page = simulate("page-drill", &file("page-drill.ngc", text), &[]);
    let (head, body) = (page.head(), page.unpacked("body"));
    let mut rest = &body[..];
    let mut feeds = Vec::new();
    for entry in head["columns"].as_array().unwrap() {
        let (column, others) = rest.split_at(entry[1].as_u64().unwrap() as usize);
        rest = others;
        if entry[0] == "feeds" {
            let mut read = Numbers::new(column);
            while !read.is_empty() {
                let (cycles, kind, _) = (read.count(), read.count(), read.count());
                feeds.push((cycles, kind));
            }
        }
    }
    let kinds: Vec<u64> = feeds.iter().map(|(_, kind)| *kind).collect();
    // Rapids down to R, 22 mm at 10 mm/s, a rapid back.
    assert_eq!(
        kinds.split(|kind| *kind == 2).filter(|fed| !fed.is_empty()).count(),
        1,
        "{feeds:?}"
    );
    let (back, _) = *feeds.last().unwrap();
    assert!((2200..2400).contains(&back), "{feeds:?}");
    page.holds(0.01, 0);
}

/// Forty thousand short lines at a feed that no two of them hold: a page of bounded size.
#[test]
fn a_dense_file_stays_small() {
    use std::fmt::Write;
    let mut random = fastrand::Rng::with_seed(7);
    let mut text = "G1 F9000\n".to_owned();
    let (mut x, mut y, mut heading) = (0.0, 0.0, 0.0f64);
    for _ in 0..40_000 {
        heading += random.f64() * 2.4 - 1.2;
        let step = 0.1 + random.f64() * 0.6;
        (x, y) = (x + step * heading.cos(), y + step * heading.sin());
        writeln!(text, "X{x:.4} Y{y:.4} Z{:.4}", -random.f64() * 0.2).unwrap();
    }
    let page =
        simulate("page-dense", &file("page-dense.ngc", &text), &["--tolerance", "0.02", "--quiet"]);
    assert!(page.text.len() <= 5 << 20, "{} bytes", page.text.len());
    let head = page.head();
    assert!(head["level"].as_u64().unwrap() > 0, "the test is to be of a run that is thinned");
    let off = head["off"].as_f64().unwrap();
    assert!(off <= 0.002, "positions are {off} mm off");
    page.holds(0.02, 0);
}
