//! The program as a user meets it: files in, files out, messages, exit codes.

use std::path::PathBuf;
use std::process::{Command, Output};

fn splineway(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_splineway")).args(arguments).output().unwrap()
}

/// A file of its own for each test.
fn file(name: &str, text: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn example() -> String {
    format!("{}/data/butterfly.json", env!("CARGO_MANIFEST_DIR"))
}

fn error_of(arguments: &[&str], code: i32) -> String {
    let output = splineway(arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{text}");
    text
}

#[test]
fn help_names_options_and_examples() {
    let output = splineway(&["simulate", "--help"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0));
    for word in [
        "--machine",
        "--tolerance",
        "--scalar",
        "--mode",
        "--setpoints",
        "--report",
        "--plot",
        "--events",
        "--compare",
        "Examples:",
    ] {
        assert!(text.contains(word), "{word} is missing");
    }
}

#[test]
fn the_example_writes_setpoints_report_and_plots() {
    let out =
        |name: &str| PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name).display().to_string();
    let (csv, json, html, svg) = (out("b.csv"), out("b.json"), out("b.html"), out("b.svg"));
    for (plot, scalar) in [(&html, "f64"), (&svg, "f32")] {
        let output = splineway(&[
            "simulate",
            &example(),
            "--tolerance",
            "0.05",
            "--feed",
            "200",
            "--scalar",
            scalar,
            "--setpoints",
            &csv,
            "--report",
            &json,
            "--plot",
            plot,
        ]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(std::fs::metadata(plot).unwrap().len() > 10_000);
    }
    let rows = std::fs::read_to_string(csv).unwrap();
    let mut rows = rows.lines();
    assert_eq!(rows.next(), Some("t,x,y,z"));
    let first: Vec<&str> = rows.next().unwrap().split(',').collect();
    assert_eq!(first.len(), 4);
    let digits = first[1].split('e').next().unwrap().chars().filter(char::is_ascii_digit).count();
    assert_eq!(digits, 15);
    let report: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
    // Cubic blocks, and a band around the curve itself: see `curves_are_run_and_judged_as_curves`.
    assert!(report["blocks"].as_u64().unwrap() > 200);
    assert_eq!(report["cycles"].as_u64().unwrap() as usize, rows.count() + 1);
    assert!(report["max_deviation_mm"].as_f64().unwrap() <= 0.05);
    assert!(report["axes"]["X"]["jerk_every_fourth_cycle"]["ratio"].as_f64().unwrap() < 1.01);
    let page = std::fs::read_to_string(html).unwrap();
    assert!(!page.contains("{{") && !page.contains("http"), "the page must stand alone");
}

#[test]
fn wrong_files_are_explained() {
    let bad = file("bad.ngc", "G1 X1 F60\nG1 Xfoo\n").display().to_string();
    assert!(error_of(&["simulate", &bad], 1).contains("bad.ngc: line 2, column 4"));
    let arc = file("arc.ngc", "G2 X10 I1 F60\n").display().to_string();
    let error = error_of(&["simulate", &arc], 1);
    let words = "line 1: arc starts 1.000000 mm from its centre but ends 9.000000 mm from it; they may differ by 0.005";
    assert!(error.contains(words), "{error}");
    let arc = file("ray.ngc", "G2 X0.004 I-5 F60\n").display().to_string();
    assert!(error_of(&["simulate", &arc], 1).contains("on the same ray"));
    let odd = file("odd.xyz", "").display().to_string();
    assert!(error_of(&["simulate", &odd], 1).contains("unknown kind of file"));
    assert!(error_of(&["simulate", "nowhere.ngc"], 1).contains("cannot read nowhere.ngc"));
    let machine = file("bad.toml", "cycle = -1\n").display().to_string();
    assert!(
        error_of(&["simulate", &example(), "--machine", &machine], 1).contains("servo cycle is -1")
    );
    let machine = file("typo.toml", "jerks = 1\n").display().to_string();
    assert!(error_of(&["simulate", &example(), "--machine", &machine], 1).contains("typo.toml"));
    assert!(
        error_of(&["simulate", &example(), "--plot", "x.bmp"], 1)
            .contains("must end in .html, .svg, .png")
    );
    error_of(&["simulate"], 2);
    error_of(&["simulate", &example(), "--scalar", "f16"], 2);
}

#[test]
fn a_tolerance_of_zero_stops_at_every_corner() {
    let square = file("square.ngc", "G1 X10 F6000\nY10\nX0\nY0\n").display().to_string();
    let time = |tolerance: &str| {
        let json =
            PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("square{tolerance}.json"));
        let json = json.display().to_string();
        let output = splineway(&["simulate", &square, "--tolerance", tolerance, "--report", &json]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let report: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(json).unwrap()).unwrap();
        (report["time_s"].as_f64().unwrap(), report["max_deviation_mm"].as_f64().unwrap())
    };
    let (stopping, off) = time("0");
    assert!(off < 1e-6, "{off}");
    let (rounding, _) = time("0.05");
    assert!(rounding < 0.9 * stopping, "{rounding} s against {stopping} s");
}

#[test]
fn arcs_helices_dwells_and_inverse_time_run() {
    let text = "G21 G17 G90\nG0 X10 Z5\nG3 X0 Y10 Z3 I-10 J0 F1200\nG3 X0 Y10 I0 J-10 P2\nG4 P0.1\nG18 G2 X5 Z8 I5 K0\n\
                G19 G3 Y12 Z10 J0 K2\nG93 G1 X0 F60\nG94 G1 A90 F3600\nG61 X1 Y1 F600\nG64 P0.1 X2\nG28\nM2\n";
    let program = file("all.ngc", text).display().to_string();
    for scalar in ["f64", "f32"] {
        let output = splineway(&["simulate", &program, "--scalar", scalar]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
}

/// The example of an operator at work: the run ends, later than without.
#[test]
fn events_are_played() {
    let path = file("zigzag.txt", "0 0 0 100\n30 0 0 100\n30 30 0 100\n60 30 0 100\n60 60 0 100\n");
    let path = path.display().to_string();
    let events = format!("{}/data/commands.csv", env!("CARGO_MANIFEST_DIR"));
    let seconds = |arguments: &[&str]| -> f64 {
        let output = splineway(arguments);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        text.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    let plain = seconds(&["simulate", &path]);
    let played = seconds(&["simulate", &path, "--events", &events]);
    assert!(played > plain + 0.3, "{played} and {plain}");
    let abort = file("abort.csv", "0.3, abort\n").display().to_string();
    assert!(seconds(&["simulate", &path, "--events", &abort]) < plain);
    // What an operator does when the program is over takes its time, and is not the program's.
    let afterwards = file("afterwards.csv", "9, jog-to, X5 at 20\n12, jog-step, Y1 at 20\n");
    assert!(seconds(&["simulate", &path, "--events", &afterwards.display().to_string()]) > 12.0);
    // Figures are of what was run: 120 mm would be more than the feed allows.
    let output = splineway(&["simulate", &path, "--events", &abort, "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let mean = report["feed"]["mean_mm_s"].as_f64().unwrap();
    assert!(report["aborted"] == true && mean > 20.0 && mean < 100.0, "{mean}");
    let wrong = file("wrong.csv", "0.3, hold\n0.4, jump\n").display().to_string();
    let error = error_of(&["simulate", &path, "--events", &wrong], 1);
    assert!(error.contains("wrong.csv") && error.contains("line 2"), "{error}");
    let held = file("held.csv", "0.3, hold\n").display().to_string();
    let error = error_of(&["simulate", &path, "--events", &held], 1);
    assert!(error.contains("needs a resume"), "{error}");
    // What is dropped is said, and that nothing was found is a failure.
    let late = file("late.csv", "0.1, abort\n0.15, resume\n9, hold\n").display().to_string();
    let output = splineway(&["simulate", &path, "--events", &late]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && said.contains("1 of the events come too late"), "{said}");
    assert!(said.contains("the first at 9 s"), "{said}");
    for (name, events, words) in [
        ("probe.csv", "0, probe, X70 at 10\n", "no contact up to X70"),
        ("home.csv", "0, home, X-20 slow 4 reach 5 back 1 at 0\n", "home: "),
    ] {
        let events = file(name, events).display().to_string();
        let error = error_of(&["simulate", &path, "--events", &events], 1);
        assert!(error.contains("not found: ") && error.contains(words), "{error}");
    }
}

/// A description of a machine is blamed for its own values only.
#[test]
fn errors_name_the_file_that_has_the_value() {
    let program = file("blame.ngc", "G1 X10 F600\n").display().to_string();
    for (text, words) in [
        ("tolerance = -1\n", "tolerance is -1 mm"),
        ("cycle = 5\n", "servo cycle is 5 s"),
        ("[axes.Y]\nvelocity = 1\nacceleration = 2\njerk = 3\n", "axes.X: the program moves"),
    ] {
        let machine = file("blame.toml", text).display().to_string();
        let error = error_of(&["simulate", &program, "--machine", &machine], 1);
        assert!(error.contains("blame.toml: ") && error.contains(words), "{error}");
    }
}

#[test]
fn other_speed_laws_and_corners_are_compared() {
    let plot = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("laws.svg");
    let name = plot.display().to_string();
    let output = splineway(&["simulate", &example(), "--compare", "--plot", &name]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && text.contains("exact stop"), "{text}");
    assert!(std::fs::read_to_string(plot).unwrap().contains("speed along the way"));
    let output = splineway(&["simulate", &example(), "--compare", "--quiet"]);
    assert!(output.status.success() && output.stdout.is_empty(), "quiet is quiet");
    let output = splineway(&["corners", "--turns", "90"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && text.contains("Guo 2023"), "{text}");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("paper");
    let output = splineway(&["paper", "--plots", &folder.display().to_string()]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let counts = "as printed here: of 6 within 2 %: 6, 10 %: 6, 25 %: 6; measured";
    assert!(output.status.success() && text.contains(counts), "{text}");
    let curves = std::fs::read_to_string(folder.join("hexagon-curvature.svg")).unwrap();
    assert!(curves.contains("transitions as printed"));
}

#[test]
fn the_papers_lambda_counts_in_its_mode() {
    let path =
        file("short.txt", "0 0 0 100\n0.2 0 0 100\n0.3 0.17 0 100\n0.2 0.34 0 100\n0 0.34 0 100\n");
    let path = path.display().to_string();
    let error = error_of(&["simulate", &path, "--lambda", "0.3"], 2);
    assert!(error.contains("--mode paper"), "{error}");
    let turns = file("turns.ngc", "G1 X10 A90 F600\n").display().to_string();
    for (program, told) in [(&turns, true), (&path, false)] {
        let output = splineway(&["simulate", program, "--reshape"]);
        let notes = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && notes.contains("gains nothing") == told, "{notes}");
    }
    let error = error_of(&["simulate", &path, "--mode", "paper", "--reshape"], 1);
    assert!(error.contains("in paper mode"), "{error}");
    let error = error_of(&["simulate", &path, "--mode", "paper", "--lambda", "1"], 2);
    assert!(error.contains("lambda"), "{error}");
    let deviation = |lambda: &str| -> f64 {
        let arguments = ["simulate", &path, "--mode", "paper", "--lambda", lambda, "--json"];
        let text = text_of(&arguments);
        let report: serde_json::Value = serde_json::from_str(&text).unwrap();
        report["max_deviation_mm"].as_f64().unwrap()
    };
    // The transitions behind the first are smaller, the first is not: it has the greatest deviation.
    assert!((deviation("0") - deviation("0.3")).abs() < 1.0e-4);
    // A corner too sharp for a transition is an exact stop, and that is said.
    let spike = file("spike.txt", "0 0 0 100\n20 0 0 100\n0 1 0 100\n0 20 0 100\n");
    let output = splineway(&["simulate", &spike.display().to_string(), "--mode", "paper"]);
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && words.contains("more than 160 degrees"), "{words}");
}

#[test]
fn smooth_writes_spline_report_and_plot() {
    let folder = std::env::temp_dir().join(format!("splineway-smooth-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/data/noisy.txt");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (out, report, plot) = (file("out.toml"), file("report.json"), file("plot.svg"));
    for method in ["thesis", "bounded"] {
        let arguments = ["smooth", example, "--method", method, "--out", &out, "--report", &report];
        let outcome = splineway(&[&arguments[..], &["--plot", &plot]].concat());
        assert!(outcome.status.success(), "{outcome:?}");
        let text = std::fs::read_to_string(&report).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let peak = |side: &str| value[side]["curvature_peak_per_mm"].as_f64().unwrap();
        assert!(peak("after") < 0.1 * peak("before"), "{method}");
        assert!(std::fs::read_to_string(&plot).unwrap().contains("</svg>"));
        // What was written runs.
        let outcome = splineway(&["simulate", &out]);
        assert!(outcome.status.success(), "{outcome:?}");
    }
    let outcome = splineway(&["smooth", example, "--tolerance", "-1"]);
    assert!(!outcome.status.success());
    let text = String::from_utf8_lossy(&outcome.stderr).into_owned();
    assert!(text.contains("tolerance radius is -1"), "{text}");
    std::fs::remove_dir_all(&folder).unwrap();
}

fn text_of(arguments: &[&str]) -> String {
    let output = splineway(arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{errors}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn check_tells_what_will_happen_and_where_time_goes() {
    let part =
        file("check.ngc", "G1 X10 F6000\nG61\nG1 Y10\nG1 X0\nG1 Y0\nG1 Y0\nG1 X5 F99999\nM2\n");
    let name = part.display().to_string();
    let text = text_of(&["check", &name, "--places", "6"]);
    for part in ["6 lines", "length    45.000 mm", "X       0.000 to 10.000", "G1 Y10"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains('\u{1b}'), "colour in a file");
    let report: serde_json::Value =
        serde_json::from_str(&text_of(&["check", &name, "--json"])).unwrap();
    assert_eq!(report["moves"]["lines"], 6);
    let advice = report["advice"].as_array().unwrap();
    for part in ["have no length", "more feed than the axes allow", "G61 for G64"] {
        assert!(advice.iter().any(|text| text.as_str().unwrap().contains(part)), "{advice:?}");
    }
    assert!(error_of(&["check", "nowhere.ngc"], 1).contains("cannot read nowhere.ngc"));
}

#[test]
fn figures_come_as_text_and_as_json() {
    let text = text_of(&["bench", &example()]);
    assert!(
        text.contains("planner") && text.contains("butterfly") && text.contains("cores"),
        "{text}"
    );
    let json: serde_json::Value =
        serde_json::from_str(&text_of(&["bench", &example(), "--json"])).unwrap();
    let path = &json["paths"][0];
    assert!(path["time_f64_s"].as_f64() < path["time_stops_s"].as_f64());
    assert!(path["broken"].as_array().unwrap().is_empty());
    let report: serde_json::Value =
        serde_json::from_str(&text_of(&["simulate", &example(), "--json"])).unwrap();
    assert!(report["time_s"].as_f64().unwrap() > 1.0);
}

#[test]
fn a_short_soak_finds_nothing_and_is_repeatable() {
    let run = || text_of(&["soak", "--cases", "12", "--seed", "200", "--threads", "1"]);
    let text = run();
    assert!(text.contains(" 0 findings"), "{text}");
    assert_eq!(text, run());
    assert!(text_of(&["soak", "--case", "200"]).contains("nothing found"));
}

#[test]
fn shells_can_complete_the_arguments() {
    for shell in ["bash", "zsh", "fish", "powershell"] {
        assert!(text_of(&["completions", shell]).contains("splineway"));
    }
}

/// `splineway ... | head` is no error.
#[cfg(unix)]
#[test]
fn a_reader_who_leaves_early_gets_no_panic() {
    use std::process::Stdio;
    let mut child = Command::new(env!("CARGO_BIN_EXE_splineway"))
        .arg("thesis")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!errors.contains("panicked"), "{errors}");
}

/// No output may be an input or another output, by any name; what cannot be written is refused by its
/// name; all before anything is run, and nothing is left behind.
#[cfg(unix)]
#[test]
fn outputs_never_overwrite_inputs_and_are_checked_first() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("outputs");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("sub")).unwrap();
    let at = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let text = "G1 X1 F600\n";
    for name in ["keep.nc", "other.nc"] {
        std::fs::write(at(name), text).unwrap();
    }
    std::os::unix::fs::symlink(at("keep.nc"), at("soft.html")).unwrap();
    std::os::unix::fs::symlink(at("fresh.csv"), at("dangling.csv")).unwrap();
    std::fs::hard_link(at("keep.nc"), at("hard.json")).unwrap();
    std::fs::write(at("mill.toml"), "tolerance = 0.01\n").unwrap();
    std::fs::write(at("play.csv"), "0.1, feed, 50\n").unwrap();
    let (keep, machine, play) = (at("keep.nc"), at("mill.toml"), at("play.csv"));
    let (dotted, soft, hard) = (at("sub/../keep.nc"), at("soft.html"), at("hard.json"));
    let (fresh, dangling) = (at("fresh.csv"), at("dangling.csv"));
    let (nowhere, sub) = (at("nowhere/x.csv"), at("sub"));
    let run = ["simulate", &keep, "--machine", &machine, "--events", &play];
    for (outputs, parts) in [
        (vec!["--setpoints", &*keep], vec!["--setpoints", "keep.nc", "input"]),
        (vec!["--setpoints", &dotted], vec!["--setpoints", "input"]),
        (vec!["--plot", &soft], vec!["--plot", "soft.html", "input"]),
        (vec!["--report", &hard], vec!["--report", "hard.json", "input"]),
        (vec!["--report", &machine], vec!["--report", "mill.toml", "--machine"]),
        (vec!["--setpoints", &play], vec!["--setpoints", "play.csv", "--events"]),
        (
            vec!["--setpoints", &fresh, "--report", &fresh],
            vec!["--report", "--setpoints", "same file"],
        ),
        (vec!["--setpoints", &fresh, "--report", &dangling], vec!["--report", "same file"]),
        (vec!["--report", &nowhere], vec!["--report", "nowhere", "cannot be written"]),
        (vec!["--setpoints", &sub], vec!["--setpoints", "sub", "folder"]),
        (vec!["--setpoints", &fresh, "--plot", "x.bmp"], vec!["--plot", "x.bmp", ".svg"]),
    ] {
        let error = error_of(&[&run[..], &outputs[..]].concat(), 1);
        for part in parts {
            assert!(error.contains(part), "{outputs:?}: {error}");
        }
        assert_eq!(std::fs::read_to_string(&keep).unwrap(), text);
        assert!(std::fs::read_to_string(&machine).unwrap().contains("tolerance"));
        assert!(!PathBuf::from(&fresh).exists(), "{outputs:?} left a file");
    }
    let spline = at("wave.toml");
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/data/noisy.txt"), at("wave.txt")).unwrap();
    let wave = at("wave.txt");
    let before = std::fs::read(&wave).unwrap();
    assert!(error_of(&["smooth", &wave, "--out", &wave], 1).contains("input"));
    assert!(
        error_of(&["smooth", &wave, "--out", &spline, "--report", &spline], 1)
            .contains("same file")
    );
    assert_eq!(std::fs::read(&wave).unwrap(), before);
    // A link that leads nowhere is written through.
    let output = splineway(&[&run[..], &["--setpoints", &dangling]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(std::fs::symlink_metadata(&dangling).unwrap().is_symlink());
    assert!(std::fs::metadata(&fresh).unwrap().len() > 100);
    // What is allowed works, again and again.
    for _ in 0..2 {
        let outputs = ["--setpoints", &*fresh, "--report", "/dev/null"];
        let output = splineway(&[&run[..], &outputs[..]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(std::fs::metadata(&fresh).unwrap().len() > 100);
    }
}

/// A full disk behind standard output, or behind a file, is an error with a message.
#[cfg(target_os = "linux")]
#[test]
fn full_outputs_are_errors_with_a_message() {
    use std::process::Stdio;
    let part = file("full.ngc", "G1 X10 F6000\n").display().to_string();
    let name = example();
    for arguments in [
        vec!["simulate", &*part],
        vec!["simulate", &*part, "--json"],
        vec!["check", &*part],
        vec!["corners", "--turns", "90"],
        vec!["completions", "bash"],
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_splineway"))
            .args(&arguments)
            .stdout(Stdio::from(full))
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {errors}");
        assert!(errors.contains("cannot write to standard output"), "{arguments:?}: {errors}");
        assert!(!errors.contains("panicked"), "{errors}");
    }
    let error = error_of(&["simulate", &name, "--quiet", "--setpoints", "/dev/full"], 1);
    assert!(error.contains("cannot write /dev/full"), "{error}");
}

/// A tolerance on the command line counts for all; else every place has its own.
#[test]
fn tolerances_are_judged_where_they_are_in_force() {
    let text = "G64 P0.2\nG1 X20 F6000\nG1 Y20\nG64 P0.01\nG1 X0\nG1 Y0\n";
    let part = file("bands.ngc", text).display().to_string();
    let report = |arguments: &[&str]| -> serde_json::Value {
        serde_json::from_str(&text_of(&[&["simulate", &*part, "--json"], arguments].concat()))
            .unwrap()
    };
    let wide = report(&[])["max_deviation_mm"].as_f64().unwrap();
    assert!(wide > 0.1 && wide < 0.2, "{wide}");
    let fine = report(&["--tolerance", "0.005"])["max_deviation_mm"].as_f64().unwrap();
    assert!(fine < 0.005 + 1e-6, "{fine}");
    let output = splineway(&["simulate", &part, "--tolerance", "0.005"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("--tolerance 0.005 counts for all"));
}

#[test]
fn curves_are_run_and_judged_as_curves() {
    let name = example();
    let off = |arguments: &[&str]| -> (f64, String) {
        let output = splineway(&[&["simulate", &*name, "--json"], arguments].concat());
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        (report["max_deviation_mm"].as_f64().unwrap(), errors)
    };
    for tolerance in ["0.01", "0.001"] {
        let (deviation, errors) = off(&["--tolerance", tolerance]);
        assert!(deviation <= tolerance.parse::<f64>().unwrap() + 1e-6, "{deviation}: {errors}");
    }
    assert!(off(&["--segments", "80"]).1.contains("80 chords, which lie up to 1.65"));
}

/// A NURBS block in a G-code file (the example of LinuxCNC's manual), and one that is not complete.
#[test]
fn nurbs_blocks_are_run_from_gcode() {
    let text = "G0 X0 Y0\nF600\nG5.2 P1 L3\nX0 Y1 P1\nX2 Y2 P1\nX2 Y0 P1\nX0 Y0 P2\nG5.3\nM2\n";
    let part = file("nurbs.ngc", text).display().to_string();
    let report = text_of(&["simulate", &part, "--tolerance", "0.01", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert!(report["max_deviation_mm"].as_f64().unwrap() <= 0.01, "{report}");
    // Round a figure of some six millimetres at 10 mm/s.
    let time = report["time_s"].as_f64().unwrap();
    assert!((0.5..1.5).contains(&time), "{report}");
    let part = file("half.ngc", &text.replace("G5.3\n", "")).display().to_string();
    let output = splineway(&["simulate", &part]);
    assert!(!output.status.success());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("M2 cannot stand in a NURBS block"), "{errors}");
}

/// Extents of arcs and curves, retractions, lines without a length, and whose fault a slow place is.
#[test]
fn check_names_the_extent_and_the_culprit() {
    let json = |name: &str, text: &str| -> serde_json::Value {
        let part = file(name, text).display().to_string();
        serde_json::from_str(&text_of(&["check", &part, "--json"])).unwrap()
    };
    let arcs = json("extent.ngc", "G1 X10 F3000\nG3 X-10 I-10 J0\nG5 I0 J-40 P0 Q-40 X30 Y0\n");
    let extent = |axis: usize, end: &str| arcs["extent"][axis][end].as_f64().unwrap();
    assert!((extent(1, "greatest_mm") - 10.0).abs() < 1e-9, "top of the arc: {arcs}");
    assert!((extent(1, "least_mm") + 30.0).abs() < 1e-3, "bottom of the curve: {arcs}");
    let advice = |report: &serde_json::Value| report["advice"].to_string();
    let empty = json("empty.ngc", "G1 X10 F600\nG1 X10 F99999\nG1 X20 F600\n");
    assert!(advice(&empty).contains("1 lines have no length"), "{empty}");
    assert!(!advice(&empty).contains("more feed"), "{empty}");
    // The corner after line 2 costs, not line 3 on which the time passes while it gets up to speed again.
    let slow =
        json("culprit.ngc", "G64 P0.01\nG1 X100 F12000\nG1 Y100\nG1 Y101 F60\nG1 Y200 F12000\n");
    let places = slow["slowest"].as_array().unwrap();
    let corner =
        places.iter().find(|place| place["cause"].as_str().unwrap().contains("corner of 90"));
    let line = corner.unwrap_or_else(|| panic!("{slow}"))["line"].as_u64().unwrap();
    assert!(line == 2 || line == 3, "{slow}");
    assert!(
        places.iter().all(|place| place["line"] != 4),
        "its feed is what was asked for: {slow}"
    );
}

/// What is lost at the beginning and the end of a run is no fault of the corner at the other end of that line; what goes nowhere has no
/// feed; and before the first line there is none.
#[test]
fn check_blames_no_corner_for_the_ends() {
    let text = "G64 P0.01\nM3 S1000\nG1 X10 F600\nX20 Y10\nM2\n";
    let part = file("ends.ngc", text).display().to_string();
    let json = |tolerance: &str| -> serde_json::Value {
        let text = text_of(&["check", &part, "--json", "--tolerance", tolerance]);
        serde_json::from_str(&text).unwrap()
    };
    let causes = |report: &serde_json::Value| -> Vec<(u64, String)> {
        let places = report["slowest"].as_array().unwrap().iter();
        places.map(|p| (p["line"].as_u64().unwrap(), p["cause"].as_str().unwrap().into())).collect()
    };
    // At this feed the corner costs less than a tenth of what the ends do.
    let found = causes(&json("0.01"));
    assert!(found.contains(&(4, "start, end or stop".into())), "{found:?}");
    assert!(found.iter().all(|(line, cause)| *line > 1 && !cause.contains("corner")), "{found:?}");
    // Where it stands in the corner, it is the corner.
    let found = causes(&json("0"));
    assert!(found.iter().any(|(_, cause)| cause.contains("corner of 45")), "{found:?}");
    let text = text_of(&["check", &part]);
    assert!(text.contains(" / - ") && !text.contains("inf"), "{text}");
    // A start without anything before it.
    let bare = file("bare.ngc", "G64 P0.01\nG1 X10 F600\nX20 Y10\n").display().to_string();
    let report: serde_json::Value =
        serde_json::from_str(&text_of(&["check", &bare, "--json"])).unwrap();
    let found = causes(&report);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found.iter().all(|(_, cause)| cause == "start, end or stop"), "{found:?}");
}

/// A line that drills has several moves, one of a subprogram is run at several feeds, and a feed word is for the linear axes where any of them
/// moves: what is asked for is what the move under way asks for.
#[test]
fn check_holds_every_move_against_its_own_feed() {
    let json = |name: &str, text: &str, more: &[&str]| -> serde_json::Value {
        let part = file(name, text).display().to_string();
        let arguments = [&["check", &part, "--json"], more].concat();
        serde_json::from_str(&text_of(&arguments)).unwrap()
    };
    let share = |report: &serde_json::Value| report["shares"]["at_feed_share"].as_f64().unwrap();
    let text = "G21 G90\nG0 Z5\nG81 X10 Y0 Z-20 R2 F60\nX20\nG80\nM2\n";
    let drilled = json("drilled.ngc", text, &[]);
    assert!(share(&drilled) > 0.95, "{drilled}");
    for place in drilled["slowest"].as_array().unwrap() {
        assert!(place["lost_s"].as_f64().unwrap() < 1.0, "{drilled}");
    }
    assert_eq!(drilled["advice"].as_array().unwrap().len(), 0, "{drilled}");
    let text = "F600\nM98 P1\nF6000\nM98 P1\nM2\nO1\nG91 G1 X100\nG90\nM99\n";
    let called = json("called.ngc", text, &[]);
    assert!(share(&called) > 0.94, "{called}");
    // The tool is at a tenth of its feed, as fast as C lets it be.
    let slow = "[axes.default]\nvelocity = 200\nacceleration = 2000\njerk = 50000\n\
                [axes.C]\nvelocity = 72\nacceleration = 720\njerk = 20000\n";
    let machine = file("slow-c.toml", slow).display().to_string();
    let text = "G21 G90 F1200\nG1 X10 C360\nG1 X20 C0\n";
    let turned = json("turned.ngc", text, &["--machine", &machine]);
    assert!(share(&turned) < 0.01, "{turned}");
    assert!(turned["advice"].to_string().contains("2 moves ask for more feed"), "{turned}");
    assert!(!turned["advice"].to_string().contains("half of the time"), "{turned}");
    let quick = json("quick.ngc", "G21 G90 F1200\nG1 X100 C36\n", &[]);
    assert!(share(&quick) > 0.9, "{quick}");
}

/// Everything that is wrong is listed at once, and nothing is run.
#[test]
fn every_finding_is_listed() {
    let text = "G1 X1 F600\nG2 X10 I1 F60\nG2 X30 I1\nG1 X0\n";
    let part = file("findings.ngc", text).display().to_string();
    for command in ["check", "simulate"] {
        let error = error_of(&[command, &part], 1);
        assert!(error.contains("line 2") && error.contains("line 3"), "{command}: {error}");
    }
}

#[test]
fn the_thesis_is_compared_and_drawn() {
    let plots = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("thesis");
    let text = text_of(&["thesis", "--plateau", "middle", "--plots", plots.to_str().unwrap()]);
    for table in 1..=7 {
        assert!(text.contains(&format!("Table 4-{table}:")), "{text}");
    }
    let last = text.trim_end().lines().last().unwrap();
    assert!(last.starts_with("Of 196 printed figures") && last.contains("; middle: "), "{last}");
    let cases = (1..=6).map(|n| format!("case{n}.svg"));
    for name in cases.chain(["correlations", "ripples"].map(|name| format!("{name}.svg"))) {
        let picture = std::fs::read_to_string(plots.join(&name)).unwrap();
        assert!(picture.contains("</svg>"), "{name}");
    }
}
