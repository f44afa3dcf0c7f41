//! What is measured of an image: symbols, sizes, stacks, setpoints, instructions.

use super::built::{Chip, Image, output, root, thumb, values};
use super::listing::Listing;
use anyhow::{Context, Result, bail, ensure};
use splineway_emulator::Outcome;
use std::path::Path;
use std::process::Command;

/// Bytes of an image by origin.
pub struct Size {
    pub own: u64,
    pub libm: u64,
    pub other: u64,
    /// RAM of a core.
    pub link: u64,
}

/// What a run in the emulator came to; counts are instructions.
pub struct Answer {
    pub outcome: Outcome,
    pub planning: u64,
    pub planning_worst: u64,
    pub tick: u64,
    pub tick_worst: u64,
}

impl Image {
    /// The example in C with the library for C, both for the target, linked to one image with every function of it.
    pub fn build_c() -> Result<Self> {
        let root = root();
        let chip = Chip::F405;
        thumb(
            chip,
            "rustc",
            &[
                "--package",
                "splineway",
                "--lib",
                "--features",
                "c-lib",
                "--crate-type",
                "staticlib",
            ],
            "the library for C does not build",
        )?;
        let folder = root.join("target/thumb/thumbv7em-none-eabihf/firmware");
        let (object, file) = (folder.join("example.o"), folder.join("example"));
        output(
            Command::new("arm-none-eabi-gcc")
                .args(["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"])
                .args(["-ffreestanding", "-std=c11", "-Wall", "-Wextra", "-Werror", "-O2", "-c"])
                .arg(root.join("host-tests/c/example.c"))
                .arg("-I")
                .arg(root.join("src/c"))
                .arg("-o")
                .arg(&object),
        )?;
        let library = Self { file: folder.join("libsplineway.a"), chip };
        output(
            Command::new("arm-none-eabi-ld")
                .args(["--entry", "example_run", "--gc-sections", "-z", "noexecstack"])
                .args(library.entries()?.iter().flat_map(|name| ["--undefined", name.as_str()]))
                .arg(&object)
                .arg(&library.file)
                .arg("-o")
                .arg(&file),
        )?;
        Ok(Self { file, chip })
    }

    /// The functions of the interface for C.
    pub fn entries(&self) -> Result<Vec<String>> {
        let names = output(Command::new("arm-none-eabi-nm").arg("--extern-only").arg(&self.file))?;
        let names = names.lines().filter_map(|line| line.split_once(" T splineway_"));
        let names: Vec<_> = names.map(|(_, name)| format!("splineway_{name}")).collect();
        ensure!(!names.is_empty(), "there is no function for C");
        Ok(names)
    }

    /// No symbol of a panic or of an allocator.
    pub fn check_symbols(&self) -> Result<()> {
        let names = output(Command::new("arm-none-eabi-nm").arg("-C").arg(&self.file))?;
        for name in ["core::panicking", "__rust_alloc", "alloc::"] {
            ensure!(!names.contains(name), "the image refers to {name}");
        }
        Ok(())
    }

    pub fn size(&self) -> Result<Size> {
        let text = output(Command::new("arm-none-eabi-nm").args(["-C", "-S"]).arg(&self.file))?;
        let mut size = Size { own: 0, libm: 0, other: 0, link: 0 };
        for line in text.lines() {
            let mut words = line.splitn(4, ' ');
            let (Some(_), Some(bytes), Some(kind), Some(name)) =
                (words.next(), words.next(), words.next(), words.next())
            else {
                continue;
            };
            let Ok(bytes) = u64::from_str_radix(bytes, 16) else { continue };
            if name.contains("LINK_3") {
                ensure!(kind == "b", "an empty core is not all zeros: it takes its size in flash");
                size.link = bytes;
            }
            // Instances for six axes; sizes of 16 or 64 are none.
            let six = ["<6>", "<6,", " 6>", " 6,", "_6"].iter().any(|six| name.contains(six));
            if !"tTrR".contains(kind) || six {
                continue;
            }
            let part = if name.contains("libm::") {
                &mut size.libm
            } else if name.contains("splineway::") || name.ends_with("_3") {
                &mut size.own
            } else {
                &mut size.other
            };
            *part += bytes;
        }
        Ok(size)
    }

    /// Its machine code.
    pub fn listing(&self) -> Result<Listing> {
        let mut command = Command::new("arm-none-eabi-objdump");
        Listing::read(&output(command.args(["-d", "-C", "--no-show-raw-insn"]).arg(&self.file))?)
    }

    /// Runs the image on a file in QEMU.
    pub fn run(&self, file: &Path) -> Result<Answer> {
        let name = file.to_str().context("the name of a temporary file")?;
        let text = self.emulate(&[name.to_owned()])?;
        let values = values(&text);
        let get = |name: &str| {
            values.get(name).copied().with_context(|| format!("no {name} in what it says: {text}"))
        };
        let outcome = Outcome {
            blocks: get("blocks")? as u32,
            cycles: get("cycles")? as u32,
            digest: get("digest")? as u32,
            complete: get("complete")? == 1,
        };
        if outcome.cycles == 0 {
            bail!("it did nothing: {text}");
        }
        Ok(Answer {
            outcome,
            planning: get("planning")?,
            planning_worst: get("planning_worst")?,
            tick: get("tick")?,
            tick_worst: get("tick_worst")?,
        })
    }
}
