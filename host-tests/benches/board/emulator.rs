//! The emulated board: started, its pins recorded, its log read.

use super::built::{Image, missing, values};
use super::recording::Recording;
use anyhow::{Context, Result, bail};
use std::collections::HashMap;
use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How long it may take to begin.
const PATIENCE: Duration = Duration::from_secs(20);

/// What is at the host's end of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// A socket, for a sender in this program.
    Socket,
    /// A pseudo-terminal, for one that others wrote.
    Terminal,
}

/// A board that runs.
pub struct Emulator {
    _qemu: Qemu,
    folder: tempfile::TempDir,
    record: File,
    inputs: UnixStream,
    /// What the pins have done so far.
    pub recording: Recording,
    /// Name of the line.
    pub line: PathBuf,
}

impl Emulator {
    /// Starts the image. An instruction takes 8 ns; the board does not run ahead of the clock, so that a sender is not slower
    /// than it would be.
    pub fn start(image: &Image, end: End) -> Result<Self> {
        let folder = tempfile::tempdir()?;
        let file = |name: &str| folder.path().join(name);
        let port = |name: &str| format!("file:{}", file(name).display());
        let socket = |name: &str| format!("unix:{},server=on,wait=off", file(name).display());
        let line = match end {
            End::Socket => socket("line"),
            End::Terminal => "pty".to_owned(),
        };
        let said = file("said");
        let output = File::create(&said)?;
        let qemu = Command::new("qemu-system-arm")
            .args(["-M", "mps2-an386", "-icount", "shift=3,align=on"])
            .args(["-nographic", "-monitor", "none", "-serial", &line])
            .args(["-serial", &port("pins"), "-serial", &port("log"), "-serial", &socket("inputs")])
            .arg("-kernel")
            .arg(&image.file)
            .stdin(Stdio::null())
            .stderr(output.try_clone()?)
            .stdout(output)
            .spawn();
        let qemu = match qemu {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                return missing("qemu-system-arm is not there");
            }
            qemu => qemu?,
        };
        let mut qemu = Qemu(qemu);
        let began = Instant::now();
        while began.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(20));
            let said = std::fs::read_to_string(&said)?;
            if let Some(status) = qemu.0.try_wait()? {
                bail!("QEMU ends with {status}: {said}");
            }
            let mut line = file("line");
            if end == End::Terminal {
                let name = said.split_whitespace().find(|word| word.starts_with("/dev/"));
                let Some(name) = name else { continue };
                line = name.into();
            }
            if let Ok(record) = File::open(file("pins"))
                && let Ok(inputs) = UnixStream::connect(file("inputs"))
                && line.exists()
            {
                let recording = Recording::new();
                return Ok(Self { record, inputs, recording, line, folder, _qemu: qemu });
            }
        }
        bail!("QEMU does not begin: {}", std::fs::read_to_string(&said)?)
    }

    /// Sets the levels of the input pins.
    pub fn set_inputs(&mut self, levels: u8) -> Result<()> {
        Ok(self.inputs.write_all(&[levels])?)
    }

    /// Reads what the pins have done since.
    ///
    /// # Errors
    /// What they did is none of a drive's, or the record is damaged.
    pub fn look(&mut self) -> Result<&Recording> {
        let mut bytes = Vec::new();
        self.record.read_to_end(&mut bytes)?;
        self.recording.read(&bytes)?;
        Ok(&self.recording)
    }

    fn text(&self) -> Result<String> {
        Ok(std::fs::read_to_string(self.folder.path().join("log"))?)
    }

    /// For every stop because blocks did not come in time, after how many servo cycles without a byte of a line.
    pub fn starved(&self) -> Result<Vec<u64>> {
        let text = self.text()?;
        let told = text.lines().filter_map(|line| line.strip_prefix("starved after a silence of "));
        let cycles = told.map(|told| told.split(' ').next().unwrap_or_default().parse());
        Ok(cycles.collect::<Result<_, _>>()?)
    }

    /// The numbers of the last line of the log.
    pub fn log(&self) -> Result<HashMap<String, u64>> {
        let text = self.text()?;
        let line = text.lines().rfind(|line| line.starts_with("state=") && line.contains("steps="));
        Ok(values(line.with_context(|| format!("the log says nothing: {text}"))?))
    }
}

/// Ends with this.
struct Qemu(Child);

impl Drop for Qemu {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
