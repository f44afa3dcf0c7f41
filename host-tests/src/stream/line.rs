//! A controller's end of a line: a pseudo-terminal, or a TCP port.

use anyhow::{Context, Result};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use std::fs::File;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Bytes that may wait for whoever is at the other end.
const ROOM: usize = 4096;
/// Time after which a sender on a network that does not read is gone.
const PATIENCE: Duration = Duration::from_secs(1);
/// How long the next sender is kept waiting while the last one leaves.
const LEAVING: Duration = Duration::from_millis(500);
/// Between looks whether it has.
const LOOK: Duration = Duration::from_millis(5);

/// What is heard on a line.
#[derive(Debug)]
pub enum Heard {
    /// Bytes.
    Bytes(Vec<u8>),
    /// Whoever sent has gone.
    HangUp,
}

/// A line that never makes the controller wait.
#[derive(Debug)]
pub struct Line {
    name: String,
    heard: Receiver<Heard>,
    out: Sender<Vec<u8>>,
    waiting: Arc<AtomicUsize>,
    /// Kept open, so that reading does not fail while nobody else has it.
    _other_end: Option<File>,
}

impl Line {
    /// A pseudo-terminal.
    ///
    /// # Errors
    /// The system has none left.
    pub fn terminal() -> Result<Self> {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
        // Nobody else's: a child process that has it too would keep it from hanging up.
        #[cfg(target_os = "linux")]
        let flags = flags | OpenptFlags::CLOEXEC;
        let terminal = openpt(flags)?;
        grantpt(&terminal)?;
        unlockpt(&terminal)?;
        let name = ptsname(&terminal, Vec::new())?.into_string().context("name of the terminal")?;
        let other_end = File::options().read(true).write(true).open(&name)?;
        // Bytes as they are: no echo, no line ends.
        let mut settings = rustix::termios::tcgetattr(&other_end)?;
        settings.make_raw();
        rustix::termios::tcsetattr(&other_end, rustix::termios::OptionalActions::Now, &settings)?;
        let mut terminal = File::from(terminal);
        let mut reader = terminal.try_clone()?;
        let (sender, heard) = channel();
        std::thread::spawn(move || pass_on(&mut reader, &sender));
        let (out, waiting) = spoken(move |chunk| terminal.write_all(chunk).is_ok());
        Ok(Self { name, heard, out, waiting, _other_end: Some(other_end) })
    }

    /// A TCP port of this computer, for one sender after another; 0 is any that is free. Whoever calls while another is there is hung up
    /// on: what it sends must not wait and be run when nobody expects it.
    ///
    /// # Errors
    /// The port is taken.
    pub fn network(port: u16) -> Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
            .with_context(|| format!("TCP port {port}"))?;
        let name = listener.local_addr()?.to_string();
        let (sender, heard) = channel();
        let current: Arc<Mutex<Option<TcpStream>>> = Arc::default();
        let owner = current.clone();
        std::thread::spawn(move || {
            let mut served: Option<JoinHandle<()>> = None;
            for stream in listener.incoming().flatten() {
                let called = Instant::now();
                let is_busy = || served.as_ref().is_some_and(|served| !served.is_finished());
                while is_busy() && called.elapsed() < LEAVING {
                    std::thread::sleep(LOOK);
                }
                let good = stream.set_nodelay(true).is_ok()
                    && stream.set_write_timeout(Some(PATIENCE)).is_ok();
                let Ok(mut reader) = stream.try_clone() else { continue };
                if is_busy() || !good {
                    continue;
                }
                *owner.lock().unwrap_or_else(PoisonError::into_inner) = Some(stream);
                let (owner, sender) = (owner.clone(), sender.clone());
                served = Some(std::thread::spawn(move || {
                    pass_on(&mut reader, &sender);
                    *owner.lock().unwrap_or_else(PoisonError::into_inner) = None;
                    // There is no line any more where nobody listens.
                    let _ = sender.send(Heard::HangUp);
                }));
            }
        });
        let (out, waiting) = spoken(move |chunk| {
            let mut current = current.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(stream) = &mut *current
                && stream.write_all(chunk).is_err()
            {
                // Nothing more is read from it either.
                let _ = stream.shutdown(Shutdown::Both);
                *current = None;
            }
            // Without a sender what is said is lost, as on a serial line.
            true
        });
        Ok(Self { name, heard, out, waiting, _other_end: None })
    }

    /// Name of the port that a host opens.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What comes.
    pub const fn heard(&self) -> &Receiver<Heard> {
        &self.heard
    }

    /// Sends bytes.
    pub fn write(&self, bytes: &[u8]) {
        if !bytes.is_empty() {
            self.waiting.fetch_add(bytes.len(), Ordering::Relaxed);
            // Nobody is there any more: as on a serial line that is cut.
            let _ = self.out.send(bytes.to_vec());
        }
    }

    /// Whether it has no room: nobody reads.
    pub fn is_full(&self) -> bool {
        self.waiting.load(Ordering::Relaxed) >= ROOM
    }
}

/// Gives on what is read, until there is no more.
fn pass_on(reader: &mut impl Read, sender: &Sender<Heard>) {
    let mut bytes = [0; 4096];
    while let Ok(count) = reader.read(&mut bytes) {
        if count == 0 || sender.send(Heard::Bytes(bytes[..count].to_vec())).is_err() {
            return;
        }
    }
}

/// A thread that writes, and how many bytes it has still to write.
fn spoken(
    mut write: impl FnMut(&[u8]) -> bool + Send + 'static,
) -> (Sender<Vec<u8>>, Arc<AtomicUsize>) {
    let (sender, receiver) = channel::<Vec<u8>>();
    let waiting = Arc::new(AtomicUsize::new(0));
    let left = waiting.clone();
    std::thread::spawn(move || {
        for chunk in receiver {
            if !write(&chunk) {
                return;
            }
            left.fetch_sub(chunk.len(), Ordering::Relaxed);
        }
    });
    (sender, waiting)
}
