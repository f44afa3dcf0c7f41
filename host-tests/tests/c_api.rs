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
 * The library is built for one size of machine; define the same here before this header is included, or
 * on the compiler's command line. A library of another size refuses to work.
 */
#ifndef SPLINEWAY_AXES
#define SPLINEWAY_AXES 3
#endif
#ifndef SPLINEWAY_BLOCKS
#define SPLINEWAY_BLOCKS 16
#endif
#ifndef SPLINEWAY_NODES
#define SPLINEWAY_NODES 64
#endif
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
        ["SPLINEWAY_AXES", "SPLINEWAY_BLOCKS", "SPLINEWAY_NODES"].map(str::to_owned).to_vec();
    let mut out = Vec::new();
    cbindgen::Builder::new()
        .with_config(config)
        .with_src(sources.join("types.rs"))
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

/// Output of a command that must succeed.
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}\n{text}{errors}");
    text
}

/// Builds the library and the example for a number of axes, and runs it.
fn example(axes: u32) -> String {
    let root = root();
    let out = root.join("target/c").join(axes.to_string());
    run(Command::new(env!("CARGO"))
        .args(["rustc", "--quiet", "--locked", "--profile", "firmware", "--package", "splineway"])
        .args(["--lib", "--features", "c-lib", "--crate-type", "staticlib", "--target-dir"])
        .arg(&out)
        .env("SPLINEWAY_AXES", axes.to_string())
        .current_dir(&root));
    let program = out.join("example");
    run(Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"])
        .arg(format!("-DSPLINEWAY_AXES={axes}"))
        .arg("-I")
        .arg(root.join("src/c"))
        .arg(root.join("host-tests/c/example.c"))
        .arg(root.join("host-tests/c/main.c"))
        .arg(out.join("firmware/libsplineway.a"))
        .arg("-o")
        .arg(&program));
    run(&mut Command::new(program))
}

#[test]
fn the_example_runs_in_three_axes_and_in_five() {
    for axes in [3, 5] {
        let text = example(axes);
        assert!(text.contains("result 0 (done)"), "{text}");
        assert!(text.contains("0 setpoints beyond a limit, 0 wrong answers"), "{text}");
        assert!(text.contains("at X0 Y0 nm, block 5"), "{text}");
    }
}
