//! Firmware images: built, and run in QEMU.

use anyhow::{Result, ensure};
use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A tool that is not there.
#[derive(Debug)]
pub struct Missing(String);

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Missing {}

pub fn missing<T>(what: &str) -> Result<T> {
    Err(Missing(what.to_owned()).into())
}

/// Standard output of a command.
pub fn output(command: &mut Command) -> Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let Ok(output) = command.output() else { return missing(&format!("{name} is not there")) };
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    ensure!(
        output.status.success(),
        "{name} failed: {text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    Ok(text)
}

/// The top level.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Cargo for the target.
pub fn thumb(verb: &str, arguments: &[&str], failed: &str) -> Result<()> {
    let mut command = Command::new("sh");
    // Cargo's own variables would point the inner cargo to the outer one's toolchain.
    let inner =
        ["CARGO_HOME", "RUSTUP_HOME", "RUSTUP_TOOLCHAIN", "CARGO_PROFILE_FIRMWARE_OPT_LEVEL"];
    for (key, _) in std::env::vars() {
        if (key.starts_with("CARGO") || key.starts_with("RUST")) && !inner.contains(&key.as_str()) {
            command.env_remove(key);
        }
    }
    let status = command
        .args([".ci/thumb.sh", verb, "--quiet", "--locked", "--profile", "firmware"])
        .args(arguments)
        .current_dir(root())
        .status()?;
    if status.code() == Some(77) {
        return missing("there is no toolchain for thumbv7em-none-eabihf");
    }
    ensure!(status.success(), "{failed}");
    Ok(())
}

/// A built image.
pub struct Image {
    /// Its file.
    pub file: PathBuf,
}

impl Image {
    /// Builds `firmware/NAME`.
    pub fn build(name: &str) -> Result<Self> {
        Self::build_of(name, name)
    }

    /// Builds an image of `firmware/FOLDER`.
    pub fn build_of(folder: &str, name: &str) -> Result<Self> {
        Self::build_with(folder, name, "")
    }

    /// The same with features.
    pub fn build_with(folder: &str, name: &str, features: &str) -> Result<Self> {
        thumb(
            "build",
            &["--package", &format!("splineway-{folder}"), "--bin", name, "--features", features],
            &format!("the image {name} does not build: a panic can be reached?"),
        )?;
        let file = root().join("target/thumb/thumbv7em-none-eabihf/firmware").join(name);
        Ok(Self { file })
    }

    /// Runs the image in QEMU with the given words on its command line; an instruction takes 2^`shift` ns. Returns what
    /// it says.
    pub fn emulate(&self, words: &[String], shift: u32) -> Result<String> {
        output(
            Command::new("qemu-system-arm")
                .args(["-M", "netduinoplus2", "-nographic", "-monitor", "none", "-serial", "none"])
                .args(["-icount", &format!("shift={shift},sleep=off,align=off")])
                .arg("-semihosting-config")
                .arg(
                    ["enable=on,target=native,arg=image"]
                        .map(str::to_owned)
                        .into_iter()
                        .chain(words.iter().cloned())
                        .collect::<Vec<_>>()
                        .join(",arg="),
                )
                .arg("-kernel")
                .arg(&self.file),
        )
    }
}

/// The numbers in what an image says: words `name=number`.
pub fn values(text: &str) -> HashMap<String, u64> {
    text.split_whitespace()
        .filter_map(|word| word.split_once('='))
        .filter_map(|(name, value)| Some((name.to_owned(), value.parse().ok()?)))
        .collect()
}
