//! The interface for C: its header is what the sources say, and the example compiles, runs and moves.

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

const PRELUDE: &str = "\
/*
 * splineway: motion interpolator core. Made from src/c by `UPDATE_HEADER=1 cargo test --test c_api`; not to
 * be edited.
 *
 * The library is built for one size of machine. Sizes and features are chosen in one place, a header
 * `splineway_config.h` in the include path, or the one that SPLINEWAY_CONFIG_FILE names; the builds with CMake and Make
 * (docs/c.md) read it too. What it does not define is as here. A library of another size refuses to work.
 *
 * Every call says which context it may come from:
 *
 *   background       The main loop, or the task of the lowest priority: one call at a time.
 *   servo interrupt  What comes once in every servo cycle, at a priority above the background's: a timer. It may interrupt
 *                    every other call, but not itself.
 *   any              These two and every other interrupt, above the servo interrupt or below it, also while any call is
 *                    under way.
 */
#if defined(SPLINEWAY_CONFIG_FILE)
#include SPLINEWAY_CONFIG_FILE
#elif defined(__has_include)
#if __has_include(\"splineway_config.h\")
#include \"splineway_config.h\"
#endif
#endif
#ifndef SPLINEWAY_AXES
#define SPLINEWAY_AXES 3
#endif
#ifndef SPLINEWAY_BLOCKS
#define SPLINEWAY_BLOCKS 16
#endif
#ifndef SPLINEWAY_NODES
#define SPLINEWAY_NODES 64
#endif
#ifndef SPLINEWAY_OUTPUTS
#define SPLINEWAY_OUTPUTS 0
#endif
#ifndef SPLINEWAY_KINEMATICS
#define SPLINEWAY_KINEMATICS 0
#endif
#ifndef SPLINEWAY_SHAPING
#define SPLINEWAY_SHAPING 0
#endif
#ifndef SPLINEWAY_HISTORY
#define SPLINEWAY_HISTORY 64
#endif
/* With this header's size and version, and the compiler's size of an enumeration, so that a library of another touches nothing. */
#define splineway_config_init(config, velocity, acceleration, jerk) \\
    splineway_config_init_sized((config), sizeof(splineway_config), \\
                                SPLINEWAY_INTERFACE + ((uint32_t)sizeof(splineway_activity) << 8), (velocity), \\
                                (acceleration), (jerk))
";

/// The header that belongs to the sources.
fn header() -> String {
    let sources = root().join("src/c");
    let mut config = cbindgen::Config {
        language: cbindgen::Language::C,
        no_includes: true,
        sys_includes: ["stdbool.h", "stddef.h", "stdint.h"].map(str::to_owned).to_vec(),
        include_guard: Some("SPLINEWAY_H".into()),
        cpp_compat: true,
        after_includes: Some(PRELUDE.into()),
        documentation_style: cbindgen::DocumentationStyle::C,
        usize_is_size_t: true,
        style: cbindgen::Style::Type,
        ..cbindgen::Config::default()
    };
    config.enumeration.rename_variants = cbindgen::RenameRule::QualifiedScreamingSnakeCase;
    // Made from the size by the prelude, not numbers of this build.
    config.export.exclude =
        ["AXES", "BLOCKS", "NODES", "OUTPUTS", "KINEMATICS", "SHAPING", "HISTORY"]
            .map(|name| format!("SPLINEWAY_{name}"))
            .to_vec();
    // For the linker of a host alone.
    config.export.exclude.push("rust_eh_personality".into());
    // Numbers of these are given, not they themselves.
    config.export.include = ["splineway_trigger", "splineway_shaper"].map(str::to_owned).to_vec();
    let mut out = Vec::new();
    cbindgen::Builder::new()
        .with_config(config)
        // The modules of this one are read with it.
        .with_src(sources.join("mod.rs"))
        .generate()
        .unwrap()
        .write(&mut out);
    String::from_utf8(out).unwrap()
}

#[test]
fn the_header_is_up_to_date() {
    let file = root().join("src/c/splineway.h");
    let header = header();
    if std::env::var_os("UPDATE_HEADER").is_some() {
        std::fs::write(&file, &header).unwrap();
    }
    let there = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        there == header,
        "src/c/splineway.h is not what the sources say: UPDATE_HEADER=1 writes it"
    );
}

/// Every function is declared once, and says which context it may come from.
#[test]
fn every_call_says_its_context() {
    let header = header();
    let mut names = Vec::new();
    let mut comment = "";
    let (_, declarations) = header.split_once("extern \"C\" {").unwrap();
    for part in declarations.split("/*\n").skip(1) {
        let (text, code) = part.split_once("*/").unwrap();
        comment = if text.trim().is_empty() { comment } else { text };
        for line in
            code.lines().filter(|line| line.contains(" splineway_") || line.contains("*splineway_"))
        {
            let Some((front, _)) = line.split_once('(') else { continue };
            let name = front.rsplit([' ', '*']).next().unwrap();
            let context = comment.trim().lines().last().unwrap().trim();
            let known = [
                "background",
                "background, while no interrupt uses this core",
                "servo interrupt",
                "any",
            ];
            assert!(
                known.iter().any(|known| context == format!("Context: {known}.")),
                "{name}: {context}"
            );
            names.push(name.to_owned());
        }
    }
    assert!(names.len() > 40, "{names:?}");
    let count = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), count, "declared twice");
}

/// Output of a command that must succeed.
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}\n{text}{errors}");
    text
}

/// Builds the library for a number of axes and a C program for another, and runs it.
fn program(name: &str, sources: &[&str], library: u32, header: u32) -> String {
    program_with(name, sources, [library, header], "c-lib", &[])
}

/// The same of a library with some features, and with what the header is told of them.
fn program_with(
    name: &str,
    sources: &[&str],
    [library, header]: [u32; 2],
    features: &str,
    told: &[&str],
) -> String {
    let root = root();
    let out = root.join("target/c").join(format!("{library}-{features}"));
    run(Command::new(env!("CARGO"))
        .args(["rustc", "--quiet", "--locked", "--profile", "firmware", "--package", "splineway"])
        .args(["--lib", "--features", features, "--crate-type", "staticlib", "--target-dir"])
        .arg(&out)
        .env("SPLINEWAY_AXES", library.to_string())
        .current_dir(&root));
    let program = out.join(name);
    run(Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"])
        .arg(format!("-DSPLINEWAY_AXES={header}"))
        .args(told)
        .arg("-I")
        .arg(root.join("src/c"))
        .args(sources.iter().map(|source| root.join("host-tests/c").join(source)))
        .arg(out.join("firmware/libsplineway.a"))
        .arg("-lm")
        .arg("-o")
        .arg(&program));
    run(&mut Command::new(program))
}

#[test]
fn the_example_runs_in_three_axes_and_in_five() {
    for axes in [3, 5] {
        let text = program("example", &["example.c", "main.c"], axes, axes);
        assert!(text.contains("result 0 (done)"), "{text}");
        assert!(text.contains("0 setpoints beyond a limit, 0 wrong answers"), "{text}");
        assert!(text.contains("at X0 Y0 nm, block 5"), "{text}");
    }
}

/// A header of another size: nothing behind its structures is written, and nothing moves.
#[test]
fn a_library_of_another_size_touches_nothing() {
    for header in [1, 2, 5, 9] {
        let text = program(&format!("mismatch{header}"), &["mismatch.c"], 3, header);
        assert_eq!(text.trim(), "refused", "header of {header} axes: {text}");
    }
}

/// Motors that follow several axes, by name of their feature: 200 mm of belt at 200 mm/s, and 0.14 s to get going.
#[test]
fn a_machine_with_belts_runs_by_its_motors() {
    let told = ["-DSPLINEWAY_KINEMATICS=1"];
    let text = program_with("motors", &["motors.c"], [3, 3], "c-lib,kinematics", &told);
    assert!(text.contains("at most 200.0 mm/s"), "{text}");
    assert!(text.contains("motors at 0 and 200000000 nm"), "{text}");
}

/// Setpoints that do not make a mass vibrate, an output that comes where they are, and what must be refused. A library without
/// shapers does not take what it cannot do.
#[test]
fn a_machine_that_vibrates_is_shaped() {
    let told = ["-DSPLINEWAY_KINEMATICS=1", "-DSPLINEWAY_OUTPUTS=1", "-DSPLINEWAY_SHAPING=1"];
    let features = "c-lib,kinematics,outputs,shaping";
    let text = program_with("shaping", &["shaping.c"], [3, 3], features, &told);
    assert!(text.contains("0 wrong"), "{text}");
    let text = program("unshaped", &["unshaped.c"], 3, 3);
    assert_eq!(text.trim(), "refused");
}
