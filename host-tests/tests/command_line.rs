//! What holds for all commands alike: defaults in the help, one meaning of an option, units in every key of JSON, standard input,
//! outputs that are checked first, lists that cannot drift from what they list.

use clap::{ArgAction, CommandFactory};
use splineway::gcode::Dialect;
use splineway_host::commands::completions::script;
use splineway_host::commands::{Arguments, gcodes};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/data");

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_splineway"))
}

/// Runs a command with something on its standard input.
fn fed(arguments: &[&str], input: &[u8]) -> Output {
    let mut child = program()
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // One that refuses its arguments does not read.
    let _ = child.stdin.take().unwrap().write_all(input);
    child.wait_with_output().unwrap()
}

fn text_of(arguments: &[&str], input: &[u8]) -> String {
    let output = fed(arguments, input);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

fn error_of(arguments: &[&str], input: &[u8]) -> String {
    let output = fed(arguments, input);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn file(name: &str, text: &str) -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// An option that takes a value says what holds without it.
#[test]
fn the_help_shows_every_default() {
    let mut count = 0;
    for command in Arguments::command().get_subcommands() {
        for argument in command.get_arguments().filter(|argument| !argument.is_positional()) {
            let takes = matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
            let name = format!("{} --{}", command.get_name(), argument.get_id());
            let help = argument.get_help().unwrap_or_else(|| panic!("{name}: no help")).to_string();
            assert!(!help.ends_with('.'), "{name}: {help}");
            let said = help.contains("[default: ") || !argument.get_default_values().is_empty();
            assert!(!takes || argument.is_required_set() || said, "{name}: {help}");
            count += usize::from(takes);
        }
    }
    assert!(count > 50, "{count} options");
}

/// A program that comes by standard input may be a file, and is no output then.
#[cfg(unix)]
#[test]
fn a_program_on_standard_input_is_not_overwritten() {
    let text = "G1 X10 F600\n";
    let name = file("piped.ngc", text);
    for option in ["--setpoints", "--report"] {
        let output = program()
            .args(["simulate", "--quiet", "-", option, &name])
            .stdin(fs::File::open(&name).unwrap())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.contains("would be overwritten"), "{said}");
        assert_eq!(fs::read_to_string(&name).unwrap(), text);
    }
}

/// What is wrong with an option is wrong usage: code 2, with its name, the value and what it must be, before anything is done.
#[test]
fn a_value_that_cannot_be_is_wrong_usage() {
    let program = file("usage.ngc", "G1 X10 F600\n");
    for (words, complaint) in [
        ("simulate FILE --tolerance -1", "'-1' for '--tolerance <MM>': it must be 0 to 1000 mm"),
        ("check FILE --tolerance=-1e-3", "'-1e-3' for '--tolerance <MM>': it must be 0 to"),
        ("reshape FILE --tolerance NaN", "'NaN' for '--tolerance <MM>': it must be 0 to 1000 mm"),
        ("limit FILE --step 0.1", "'0.1' for '--step <MS>': it must be 0.25 to 50 ms"),
        ("limit FILE --longest 0", "'0' for '--longest <S>': it must be above 0"),
        ("limit FILE FILE --setpoints a.csv", "--setpoints is for one file; there are 2"),
        ("check FILE --tolerance -.5", "'-.5' for '--tolerance <MM>': it must be 0 to 1000 mm"),
        ("check FILE --places -1", "it must be a whole number from 0 to 1000000"),
        ("limit FILE --rounds 1.5", "'1.5' for '--rounds <COUNT>': it must be a whole number"),
        ("simulate FILE --sweeps 101", "it must be a whole number from 0 to 100"),
        ("simulate FILE --segments 0", "it must be a whole number from 1 to 1000000"),
        ("simulate FILE --lookahead 32", "it must be one of [16, 64, 256]"),
        ("simulate FILE --cycle 0", "'0' for '--cycle <S>': it must be 0.000001 to 0.01 s"),
        ("simulate FILE --feed NaN", "'NaN' for '--feed <MM_PER_S>': it must be"),
        ("simulate FILE --lambda 1", "'1' for '--lambda <SHARE>': it must be 0 to 0.99\n"),
        ("simulate FILE --lambda 0.5", "--lambda 0.5: it counts in paper mode only"),
        ("check FILE --feed 0", "'0' for '--feed <MM_PER_S>': it must be"),
        ("limit FILE --feed inf", "'inf' for '--feed <MM_PER_S>': it must be"),
        ("reshape FILE --feed -1e9", "'-1e9' for '--feed <MM_PER_S>': it must be"),
        ("stream FILE --port no --feed -1", "'-1' for '--feed <MM_PER_S>': it must be"),
        ("stream FILE --port no --watchdog 0.05", "it must be 0.1 to 60 s, or 0 for never"),
        ("stream FILE --port no --laser 0", "'0' for '--laser <POWER>': it must be above 0"),
        ("smooth FILE --jerk 0", "'0' for '--jerk <MM_PER_S3>': it must be above 0"),
        ("corners --turns 90,180", "'180' for '--turns <DEGREES>': it must be 15 to 155 degrees"),
        ("corners --tolerance 0", "it must be above 0 and at most 0.2 mm"),
        ("controller --axes 4", "'4' for '--axes <COUNT>': it must be one of [3, 6, 9]"),
        ("controller --speed inf", "'inf' for '--speed <FACTOR>': it must be above 0"),
        ("controller --faults 2", "'2' for '--faults <SHARE>': it must be 0 to 0.5\n"),
        ("controller --protocol grbl --once", "--once: it ends after a program"),
        ("controller --protocol grbl --faults 0.1", "--faults 0.1: they are for the protocol"),
        ("controller --settings a.txt", "--settings: they are kept with --protocol grbl only"),
    ] {
        if cfg!(not(unix)) && words.starts_with("controller") {
            continue;
        }
        let words = words.split(' ').map(|word| if word == "FILE" { &*program } else { word });
        let words: Vec<&str> = words.collect();
        let output = fed(&words, b"");
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert!(output.stdout.is_empty() && said.contains(complaint), "{words:?}: {said}");
    }
}

/// `--feed`, `--machine`, `--tolerance` and the rest mean the same wherever they are.
#[test]
fn an_option_has_one_meaning() {
    let mut seen: BTreeMap<String, (String, String)> = BTreeMap::new();
    let of_its_own = [
        // A spline's tolerance and feed are in its file; what `corners` and `controller` take of a machine is said there.
        ("smooth", "tolerance"),
        ("smooth", "feed"),
        ("corners", "tolerance"),
        ("corners", "machine"),
        ("controller", "machine"),
    ];
    for command in Arguments::command().get_subcommands() {
        for argument in command.get_arguments() {
            let id = argument.get_id().to_string();
            if !["feed", "machine", "tolerance", "dialect", "lenient", "block_delete"]
                .contains(&&*id)
                || of_its_own.contains(&(command.get_name(), &*id))
                || command.get_name() == "gcodes"
            {
                continue;
            }
            let help = argument.get_help().unwrap().to_string();
            let (first, text) =
                seen.entry(id.clone()).or_insert((command.get_name().to_owned(), help.clone()));
            assert_eq!(*text, help, "--{id} of {} and of {first}", command.get_name());
        }
    }
    assert_eq!(seen.len(), 6);
}

/// Feeds of a file give way to that of the command line, in every command that has one, and without it nothing changes.
#[test]
fn the_feed_takes_the_place_of_those_of_the_file() {
    let slow = file("slow.ngc", "G64 P0.05\nG1 X30 F300\nG1 Y30 F600\nG93 G1 X0 F30\nG94 G0 Y0\n");
    let plain = file("plain.ngc", "G64 P0.05\nG1 X30\nG1 Y30\nG1 X0\nG0 Y0\n");
    for command in ["simulate", "check"] {
        let time = |path: &str, more: &[&str]| -> f64 {
            let text = text_of(&[&[command, path, "--json"], more].concat(), b"");
            serde_json::from_str::<serde_json::Value>(&text).unwrap()["time_s"].as_f64().unwrap()
        };
        let ours = time(&slow, &["--feed", "50"]);
        assert!((ours - time(&plain, &[])).abs() < 2e-3, "{command}: {ours} s");
        assert!(time(&slow, &[]) > 3.0 * ours, "{command}");
        let note = fed(&[command, &slow, "--feed", "50", "--quiet"], b"");
        let note = String::from_utf8_lossy(&note.stderr).into_owned();
        assert!(note.contains("3 moves name another"), "{command}: {note}");
    }
}

/// What a number is counted in, by its key.
fn has_unit(key: &str) -> bool {
    const UNITS: [&str; 17] = [
        "_s", "_ms", "_mm", "_deg", "_mm_s", "_mm_s2", "_mm_s3", "_deg_s", "_deg_s2", "_deg_s3",
        "_per_mm", "_per_mm2", "_bytes", "_share", "_ratio", "_percent", "_nm",
    ];
    /// Things that are counted, and numbers that are names.
    const COUNTED: [&str; 32] = [
        "arcs",
        "axes",
        "blocks",
        "case",
        "cases",
        "cores",
        "curves",
        "cycles",
        "damaged_frames",
        "dwells",
        "findings_by_rule",
        "iterations",
        "items_sent",
        "late_plans",
        "least_look_ahead_nodes",
        "line",
        "lines",
        "nodes",
        "plans",
        "ratio",
        "refused",
        "rounds",
        "slower_cases",
        "slowest_case",
        "starved",
        "steps",
        "stops",
        "operations",
        "number",
        "places",
        "turns",
        "windows",
    ];
    UNITS.iter().any(|unit| key.ends_with(unit))
        || key.starts_with("ns_per_")
        || COUNTED.contains(&key)
}

/// Numbers without a unit in their key, or in one above it, or beside them.
fn bare(value: &serde_json::Value, path: &str, told: bool, out: &mut BTreeSet<String>) {
    match value {
        serde_json::Value::Object(members) => {
            let told = told || members.get("unit").is_some_and(serde_json::Value::is_string);
            for (key, value) in members {
                // A count is one of what it names, and nothing below it.
                bare(value, &format!("{path}.{key}"), told || has_unit(key) && key != "axes", out);
            }
        }
        serde_json::Value::Array(list) => {
            for value in list {
                bare(value, path, told, out);
            }
        }
        serde_json::Value::Number(_) if !told && path.rsplit('.').next() != Some("axes") => {
            out.insert(path.to_owned());
        }
        _ => {}
    }
}

#[test]
fn every_figure_has_its_unit() {
    let part =
        file("units.ngc", "G64 P0.05\nM3 S100\nG1 X5 F3000\nG3 X0 Y5 I-5 J0 A90\nG4 P0.1\nM5\n");
    let line = file("line.txt", "0 0 0 100\n3 0 0 100\n3 3 0 100\n");
    let noisy = format!("{DATA}/noisy.txt");
    let motors = format!("{DATA}/corexy.toml");
    for arguments in [
        vec!["simulate", &*part],
        vec!["simulate", &line, "--machine", &motors],
        vec!["check", &part],
        vec!["limit", &line, "--rounds", "2"],
        vec!["reshape", &line],
        vec!["smooth", &noisy],
        vec!["bench", &line],
        vec!["soak", "--cases", "3", "--threads", "1"],
        vec!["corners", "--turns", "90"],
        vec!["paper"],
        vec!["thesis"],
        vec!["gcodes", "--all"],
    ] {
        let text = text_of(&[&arguments[..], &["--json"]].concat(), b"");
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let mut without = BTreeSet::new();
        bare(&value, "", false, &mut without);
        assert!(without.is_empty(), "{arguments:?}: {without:?}");
        assert!(text.len() > 100, "{arguments:?}: {text}");
    }
    let report = text_of(&["simulate", &part, "--json"], b"");
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert!(report["axes"]["X"]["velocity"]["peak_mm_s"].as_f64().unwrap() > 1.0, "{report}");
    assert!(report["axes"]["A"]["velocity"]["peak_deg_s"].as_f64().unwrap() > 1.0, "{report}");
    // The same figures in a file.
    let out = folder("units").join("report.json");
    text_of(&["simulate", &part, "--quiet", "--report", out.to_str().unwrap()], b"");
    let written: serde_json::Value = serde_json::from_slice(&fs::read(&out).unwrap()).unwrap();
    assert_eq!(written["cycles"], report["cycles"]);
}

/// Every command that reads a file takes it from standard input, and tells what it is by what is in it.
#[test]
fn standard_input_is_a_file_like_any_other() {
    let read = |name: &str| fs::read(format!("{DATA}/{name}")).unwrap();
    for (arguments, input) in [
        (&["simulate", "-"][..], &b"G1 X1 F600\n"[..]),
        (&["simulate", "-"], &read("butterfly.json")),
        (&["simulate", "-"], &read("zigzag.txt")),
        (&["simulate", "-"], &read("noisy.txt")),
        (&["check", "-"], b"\xff\xfeG\x001\x00X\x001\x00F\x001\x00"),
        (&["check", "-"], &read("zigzag.txt")),
        (&["limit", "-", "--rounds", "3"], b"G1 X1 F600\n"),
        (&["reshape", "-"], b"G1 X1 F600\n"),
        (&["smooth", "-"], &read("noisy.txt")),
        (&["bench", "-"], b"0 0 0 100\n3 0 0 100\n"),
    ] {
        assert!(!text_of(arguments, input).is_empty(), "{arguments:?}");
    }
    let square = format!("{DATA}/square.ngc");
    let time = |arguments: &[&str], input: &[u8]| {
        let text = text_of(&[&["simulate", &square, "--json"], arguments].concat(), input);
        serde_json::from_str::<serde_json::Value>(&text).unwrap()["time_s"].as_f64().unwrap()
    };
    let plain = time(&[], b"");
    assert!(
        time(&["--machine", "-"], b"[axes.default]\nvelocity=5\nacceleration=50\njerk=500\n")
            > plain
    );
    assert!(time(&["--events", "-"], b"0.1, hold\n1.1, resume\n") > plain + 0.9);
    let error = error_of(&["simulate", "-", "--events", "-"], b"");
    assert!(error.contains("--events -: the program is standard input already"), "{error}");
    assert!(error_of(&["check", "-", "--machine", "-"], b"").contains("standard input already"));
    assert!(error_of(&["smooth", "-"], b"G1 X1\n").contains("-: line 1"));
    assert!(error_of(&["simulate", "-", "--machine", "-"], b"").contains("standard input already"));
}

/// Programs are gone through: a longer one takes the room of its text more, and no lists.
#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_program() {
    let most = |command: &str, bytes: usize| -> usize {
        let path = folder(&format!("memory-{command}-{bytes}")).join("relief.ngc");
        let mut text = Vec::new();
        splineway_studies::paths::relief(&mut text, bytes).unwrap();
        fs::write(&path, text).unwrap();
        let mut child = program()
            .args([command, path.to_str().unwrap(), "--quiet"])
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut most = 0;
        while child.try_wait().unwrap().is_none() {
            let status = fs::read_to_string(format!("/proc/{}/status", child.id()));
            let status = status.unwrap_or_default();
            let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
            most = most.max(kilobytes.unwrap_or(0));
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        assert!(child.wait().unwrap().success());
        most
    };
    for command in ["simulate", "check"] {
        let (short, long) = (most(command, 100_000), most(command, 1_000_000));
        // Of lists, these 35,000 lines took some 25 MB.
        assert!(short > 1000 && long < short + 4000, "{command}: {short} kB, {long} kB");
    }
}

/// What `machine` prints is the built-in one to the last bit: a run does not change.
#[test]
fn the_machine_that_is_printed_is_the_one_that_runs() {
    let text = text_of(&["machine"], b"");
    let square = format!("{DATA}/square.ngc");
    let run = |arguments: &[&str]| {
        let out = folder("machine").join("setpoints.csv");
        let all =
            [&["simulate", &*square, "--quiet", "--setpoints", out.to_str().unwrap()], arguments];
        text_of(&all.concat(), text.as_bytes());
        fs::read(&out).unwrap()
    };
    assert!(run(&[]) == run(&["--machine", "-"]), "setpoints differ");
}

/// The page of G-codes names what the reader reads, all of it and nothing else.
#[test]
fn the_page_of_gcodes_lists_what_is_read() {
    let read: Vec<String> = gcodes::rows(Dialect::LinuxCnc)
        .into_iter()
        .filter(|row| row.handling == "read")
        .map(|row| row.code)
        .collect();
    let page =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/gcodes.md")).unwrap();
    let mut named = BTreeSet::new();
    let number = |code: &str| -> Option<(char, f64)> {
        Some((code.chars().next()?, code.get(1..)?.parse().ok()?))
    };
    let is_code = |word: &&str| {
        word.starts_with(['G', 'M']) && number(word.split('-').next().unwrap()).is_some()
    };
    for row in page.lines().filter(|line| line.starts_with("| ")) {
        let Some(codes) = row.split('|').nth(1) else { continue };
        let words = codes.split([' ', ',']).filter(|word| !word.is_empty());
        for word in words.filter(is_code) {
            let (first, last) = word.split_once('-').unwrap_or((word, word));
            for end in [first, last] {
                assert!(read.contains(&end.to_owned()), "{end} is on the page and not read");
            }
            let (first, last) = (number(first).unwrap(), number(last).unwrap());
            let within = |code: &&String| {
                let code = number(code).unwrap();
                code.0 == first.0 && code.1 >= first.1 && code.1 <= last.1
            };
            named.extend(read.iter().filter(within).cloned());
        }
    }
    let missing: Vec<&String> = read.iter().filter(|code| !named.contains(*code)).collect();
    assert!(missing.is_empty(), "read, and not on the page: {missing:?}");
    let printed = text_of(&["gcodes"], b"");
    for code in &read {
        assert!(printed.lines().any(|line| line.split(' ').next() == Some(code)), "{code}");
    }
    assert!(text_of(&["gcodes", "--dialect", "marlin", "--all"], b"").contains("M104   left out"));
}

#[test]
fn the_formats_are_listed() {
    let text = text_of(&["formats"], b"");
    for word in
        [".ngc", ".mpf", ".txt", "control_points", "quick-hold", "splineway machine", "_mm_s2"]
    {
        assert!(text.contains(word), "{word}: {text}");
    }
}

/// Before anything is read, run or opened.
#[cfg(unix)]
#[test]
fn what_cannot_be_written_is_said_first() {
    let folder = folder("first");
    let blocked = file("first/blocked", "");
    let inside = format!("{blocked}/inside");
    let line = file("first/line.txt", "0 0 0 100\n3 0 0 100\n");
    let machine = file("first/mill.toml", "tolerance = 0.01\n");
    let begun = std::time::Instant::now();
    for arguments in [
        vec!["limit", &*line, "--setpoints", &inside],
        vec!["limit", &line, "--setpoints", &line],
        vec!["reshape", &*line, "--setpoints", &inside],
        vec!["reshape", &line, "--setpoints", &line],
        vec!["thesis", "--plots", &inside],
        vec!["thesis", "--plots", &blocked],
        vec!["paper", "--plots", &blocked],
        vec!["controller", "--protocol", "grbl", "--settings", &inside],
        vec!["controller", "--protocol", "grbl", "--settings", &line],
        vec!["controller", "--protocol", "grbl", "--machine", &machine, "--settings", &machine],
        vec!["simulate", &line, "--plot", &inside],
        // No file of that name: who writes this means standard output.
        vec!["simulate", &line, "--setpoints", "-"],
        vec!["simulate", &line, "--report", "-"],
    ] {
        let error = error_of(&arguments, b"");
        assert!(error.starts_with("error: --"), "{arguments:?}: {error}");
    }
    assert!(begun.elapsed().as_secs_f64() < 10.0);
    assert!(!Path::new("-").exists());
    assert_eq!(fs::read(&blocked).unwrap(), b"");
    assert!(fs::read_to_string(&machine).unwrap().contains("tolerance"));
    assert!(fs::read_to_string(&line).unwrap().ends_with("3 0 0 100\n"));
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 3);
}

/// One command runs a file and opens its page with whatever this computer opens pages with.
#[cfg(target_os = "linux")]
#[test]
fn a_page_is_opened() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("open");
    let opener = folder.join("xdg-open");
    let told = folder.join("told");
    fs::write(&opener, format!("#!/bin/sh\nprintf '%s' \"$1\" > {}\n", told.display())).unwrap();
    fs::set_permissions(&opener, fs::Permissions::from_mode(0o755)).unwrap();
    let paths = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap_or_default());
    let square = format!("{DATA}/square.ngc");
    let page = folder.join("own.html");
    for (more, expected) in [(vec![], None), (vec!["--plot", page.to_str().unwrap()], Some(&page))]
    {
        let output = program()
            .args(["simulate", &square, "--open"])
            .args(&more)
            .env("PATH", &paths)
            .env("TMPDIR", &folder)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        // The program that opens it is not waited for.
        let begun = std::time::Instant::now();
        while !told.exists() || fs::read(&told).unwrap().is_empty() {
            assert!(begun.elapsed().as_secs() < 20, "nothing was opened");
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        let opened = PathBuf::from(fs::read_to_string(&told).unwrap());
        assert!(fs::read_to_string(&opened).unwrap().contains("<html"), "{}", opened.display());
        assert!(expected.is_none_or(|page| *page == opened), "{}", opened.display());
        fs::remove_file(&told).unwrap();
    }
}

/// Whatever a negative number is for, the answer is about that value, and not about an argument that nobody knows.
#[test]
fn negative_numbers_are_refused_as_such() {
    for (command, option) in [
        ("controller", "--axes"),
        ("controller", "--speed"),
        ("controller", "--faults"),
        ("soak", "--cases"),
        ("soak", "--threads"),
    ] {
        let output = fed(&[command, option, "-1"], b"");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && !said.contains("unexpected"), "{said}");
        assert!(said.contains("-1") && said.contains("must be"), "{said}");
    }
}

#[test]
fn chords_are_for_curves() {
    for name in ["square.ngc", "zigzag.txt"] {
        let said = error_of(&["simulate", &format!("{DATA}/{name}"), "--segments", "20"], b"");
        assert!(said.contains(name), "{said}");
        assert!(said.contains("only a NURBS curve can be run as 20 chords"), "{said}");
    }
    let said = error_of(&["simulate", "-", "--segments", "20"], b"G1 X1 F60\n");
    assert!(said.contains("20 chords"), "{said}");
}

/// Those in the repository are those that the program prints; `UPDATE=1 cargo test` writes them.
#[test]
fn completions_in_the_repository_are_the_programs() {
    use clap_complete::Shell;
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/completions"));
    for (name, shell) in [
        ("splineway.bash", Shell::Bash),
        ("_splineway", Shell::Zsh),
        ("splineway.fish", Shell::Fish),
        ("splineway.ps1", Shell::PowerShell),
        ("splineway.elv", Shell::Elvish),
    ] {
        let (path, text) = (folder.join(name), script(shell));
        if std::env::var_os("UPDATE").is_some() {
            fs::create_dir_all(folder).unwrap();
            fs::write(&path, &text).unwrap();
        }
        let kept = fs::read_to_string(&path).unwrap_or_default();
        assert!(
            kept == text,
            "{name} is not what the program prints: UPDATE=1 cargo test -p splineway-host --test command_line"
        );
    }
}

/// What came of probes and homing stands in the report, by the letters of the axes; what found nothing, or was cancelled, is an error.
#[test]
fn the_report_says_what_was_sought() {
    let part = file("sought.ngc", "G0 X1\n");
    let sought = |events: &str, code: i32| -> (serde_json::Value, String) {
        let output = fed(&["simulate", &part, "--json", "--events", "-"], events.as_bytes());
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{errors}");
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (report["sought"][0].clone(), errors)
    };
    let (found, _) = sought("0, surface, Z<-5\n0.1, probe, Z-10 at 5\n", 0);
    assert_eq!((&found["kind"], &found["outcome"]), (&"probe".into(), &"tripped".into()));
    let z = |place: &str| found[place]["Z_mm"].as_f64().unwrap();
    assert!((z("edge") + 5.0).abs() < 1e-6 && z("rest") < z("edge"), "{found}");
    assert!(found["time_s"].as_f64().unwrap() > 1.0, "{found}");
    let (cancelled, error) = sought("0.1, probe, Z-10 at 5\n0.5, jog-cancel\n", 1);
    assert_eq!(cancelled["outcome"], "cancelled", "{error}");
    let (missed, _) = sought("0.1, probe, Z-1 at 5\n", 1);
    assert_eq!(missed["outcome"], "missed");
    assert!(missed.get("edge").is_none(), "{missed}");
    let (failed, error) = sought("0.1, home, X-50 slow 5 reach 30 back 2 at 0\n", 1);
    assert_eq!(failed["failure"], "X, seeking its switch: the switch does not close", "{error}");
    let (homed, _) =
        sought("0, switch, X<-20\n0.1, home, X-50 slow 5 reach 30 back 2 at 0 park 3\n", 0);
    assert_eq!(homed["outcome"], "homed");
    assert!((homed["rest"]["X_mm"].as_f64().unwrap() - 3.0).abs() < 1e-6, "{homed}");
}

/// A run that stands still when its events are over names what is missing.
#[test]
fn what_holds_a_run_is_named() {
    let part = file("held.ngc", "G1 X10 F600\nM0\nG0 X20\n");
    let error = |events: &str| error_of(&["simulate", &part, "--events", "-"], events.as_bytes());
    assert!(error("0.1, hold\n").contains("needs a resume"));
    assert!(error("0.1, feed, 0\n").contains("feed is 0 %; it needs a value above 0"));
    assert!(error("0.1, rapid, 0\n").contains("rapid is 0 %"));
    assert!(error("0.1, hold\n0.2, feed, 0\n").contains("needs a resume"));
    let jogged = error("0.1, hold\n3, jog-to, X2e5 at 5\n3.1, jog-to, X20 Y2000000 at 1\n");
    assert!(!jogged.contains("axis"), "{jogged}");
    let travel = file("held.toml", "[travel]\nX = { least = -1, greatest = 30 }\n");
    let events = file("held.csv", "3, jog-to, X100 at 5\n");
    let outside = error_of(&["simulate", &part, "--machine", &travel, "--events", &events], b"");
    assert!(outside.contains("X would go to 100 mm"), "{outside}");
}

/// A mark of UTF-8 is no part of any file.
#[test]
fn every_file_may_begin_with_the_mark_of_utf_8() {
    let marked = |text: &[u8]| [b"\xef\xbb\xbf", text].concat();
    for (name, command) in [
        ("zigzag.txt", "simulate"),
        ("butterfly.json", "simulate"),
        ("noisy.txt", "smooth"),
        ("square.ngc", "check"),
    ] {
        let text = marked(&fs::read(format!("{DATA}/{name}")).unwrap());
        assert!(!text_of(&[command, "-"], &text).is_empty(), "{name}");
        let path = folder("marked").join(name);
        fs::write(&path, text).unwrap();
        assert!(!text_of(&[command, path.to_str().unwrap()], b"").is_empty(), "{name}");
    }
    let square = format!("{DATA}/square.ngc");
    let machine = marked(b"tolerance = 0.1\n");
    assert!(!text_of(&["check", &square, "--machine", "-"], &machine).is_empty());
    text_of(&["simulate", &square, "--events", "-"], &marked(b"0.1, hold\n0.2, resume\n"));
}

/// An input that cannot be read is known before the first one is run.
#[test]
fn all_inputs_are_looked_at_first() {
    let part = file("first.ngc", "G1 X1 F600\n");
    for command in ["limit", "reshape", "bench"] {
        let output = fed(&[command, &part, "nowhere.ngc"], b"");
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{command}");
        assert!(errors.contains("cannot read nowhere.ngc"), "{command}: {errors}");
        assert!(output.stdout.is_empty(), "{command} has begun");
    }
    assert!(error_of(&["limit", DATA], b"").contains("it is a folder"));
}
