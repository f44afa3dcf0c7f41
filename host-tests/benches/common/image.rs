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

/// Cargo for a chip.
pub fn thumb(chip: Chip, verb: &str, arguments: &[&str], failed: &str) -> Result<()> {
    let mut command = Command::new("sh");
    let [processor, target] = chip.build();
    command.env("THUMB_CPU", processor).env("THUMB_TARGET_DIR", target);
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

/// A chip that QEMU emulates, and the time of an instruction there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chip {
    /// STM32F405, a Cortex-M4F with 128 KiB of RAM; 64 ns: the emulator's timers are as exact as an instruction.
    F405,
    /// A Cortex-M4F; 8 ns: about 168 MHz at 1.35 cycles for one.
    M4,
    /// A Cortex-M7; 2 ns: 500 MHz at a cycle for one.
    M7,
}

impl Chip {
    fn machine(self) -> &'static str {
        match self {
            Self::F405 => "netduinoplus2",
            Self::M4 => "mps2-an386",
            Self::M7 => "mps2-an500",
        }
    }

    /// Time of an instruction, ns.
    pub fn instruction(self) -> u32 {
        1 << self.shift()
    }

    fn shift(self) -> u32 {
        match self {
            Self::F405 => 6,
            Self::M4 => 3,
            Self::M7 => 1,
        }
    }

    /// What it is built for, and in which folder.
    fn build(self) -> [&'static str; 2] {
        if self == Self::M7 {
            ["cortex-m7", "target/thumb-m7"]
        } else {
            ["cortex-m4", "target/thumb"]
        }
    }
}

/// A built image.
pub struct Image {
    /// Its file.
    pub file: PathBuf,
    /// What it is for.
    pub chip: Chip,
}

impl Image {
    /// Builds `firmware/NAME`.
    pub fn build(name: &str) -> Result<Self> {
        Self::build_of(name, name)
    }

    /// Builds an image of `firmware/FOLDER`.
    pub fn build_of(folder: &str, name: &str) -> Result<Self> {
        Self::build_for(Chip::F405, folder, name, "")
    }

    /// The same with features.
    pub fn build_with(folder: &str, name: &str, features: &str) -> Result<Self> {
        Self::build_for(Chip::F405, folder, name, features)
    }

    /// The same for a chip.
    pub fn build_for(chip: Chip, folder: &str, name: &str, features: &str) -> Result<Self> {
        thumb(
            chip,
            "build",
            &["--package", &format!("splineway-{folder}"), "--bin", name, "--features", features],
            &format!("the image {name} does not build: a panic can be reached?"),
        )?;
        let [_, target] = chip.build();
        let file = root().join(target).join("thumbv7em-none-eabihf/firmware").join(name);
        Ok(Self { file, chip })
    }

    /// Runs the image in QEMU with the given words on its command line. Returns what it says.
    pub fn emulate(&self, words: &[String]) -> Result<String> {
        let machine = self.chip.machine();
        output(
            Command::new("qemu-system-arm")
                .args(["-M", machine, "-nographic", "-monitor", "none", "-serial", "none"])
                .args(["-icount", &format!("shift={},sleep=off,align=off", self.chip.shift())])
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
