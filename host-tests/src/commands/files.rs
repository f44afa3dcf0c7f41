//! Files that a command reads and writes: no output may be an input, or another output, under any name,
//! and all of them can be written before anything is run.

use anyhow::{Context, Result, bail};
use splineway_simulator::input::is_stdin;
use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};

/// A file and the option or argument that names it.
pub type Named<'a> = (&'a str, &'a Path);

/// An output as it is on the disk: files that were made by looking are gone with this.
struct Probe {
    made: Option<PathBuf>,
    identity: Option<Identity>,
}

impl Drop for Probe {
    fn drop(&mut self) {
        if let Some(path) = &self.made {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// What is the same for all names of a file: links of either kind, ways through other folders.
#[derive(Debug, PartialEq, Eq)]
struct Identity(Vec<u8>);

#[cfg(unix)]
fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    // It may be a file.
    let path = if is_stdin(path) { Path::new("/dev/stdin") } else { path };
    let data = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    Some(Identity([data.dev().to_ne_bytes(), data.ino().to_ne_bytes()].concat()))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<Identity> {
    let path = std::fs::canonicalize(path).ok().filter(|path| path.is_file())?;
    Some(Identity(path.to_string_lossy().into_owned().into_bytes()))
}

/// Opens an output without changing it. Devices and pipes are taken as they are.
fn probe((option, path): Named<'_>) -> Result<Probe> {
    let refusal = || format!("{option} {}: cannot be written", path.display());
    if is_stdin(path) {
        bail!(
            "{}: - is standard input, where files are read (a file of this name: ./-)",
            refusal()
        );
    }
    let exists = match std::fs::metadata(path) {
        Ok(data) if data.is_dir() => bail!("{}: it is a folder", refusal()),
        Ok(data) if !data.is_file() => return Ok(Probe { made: None, identity: None }),
        Ok(_) => true,
        Err(_) => false,
    };
    let _: File = OpenOptions::new()
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)
        .with_context(refusal)?;
    // A link that leads nowhere has made the file it leads to, and is kept.
    let made = if exists { None } else { std::fs::canonicalize(path).ok() };
    Ok(Probe { made, identity: identity(path) })
}

/// Refuses outputs that would overwrite an input or each other, or that cannot be written, and inputs that cannot be read, or of which
/// more than one is standard input.
///
/// # Errors
/// Names the two, or the one.
pub fn check(inputs: &[Option<Named<'_>>], outputs: &[Option<Named<'_>>]) -> Result<()> {
    check_stdin(inputs)?;
    inputs.iter().flatten().try_for_each(|(_, path)| check_readable(path))?;
    let mut kept: Vec<(Named<'_>, Probe)> = Vec::new();
    for &(option, path) in outputs.iter().flatten() {
        let own = identity(path);
        for (what, input) in inputs.iter().flatten() {
            if own.is_some() && identity(input) == own {
                bail!(
                    "{option} {}: this is the input {} ({what}); it would be overwritten",
                    path.display(),
                    input.display()
                );
            }
        }
        let probe = probe((option, path))?;
        for ((other, first), earlier) in &kept {
            if probe.identity.is_some() && probe.identity == earlier.identity {
                bail!(
                    "{option} {}: {other} {} goes to the same file",
                    path.display(),
                    first.display()
                );
            }
        }
        kept.push(((option, path), probe));
    }
    Ok(())
}

/// Refuses an input that cannot be read. Devices and pipes are taken as they are.
///
/// # Errors
/// Names it.
pub fn check_readable(path: &Path) -> Result<()> {
    let refusal = || format!("cannot read {}", path.display());
    if is_stdin(path) {
        return Ok(());
    }
    let data = std::fs::metadata(path).with_context(refusal)?;
    if data.is_dir() {
        bail!("{}: it is a folder", refusal());
    }
    if data.is_file() {
        File::open(path).with_context(refusal)?;
    }
    Ok(())
}

/// Refuses inputs of which more than one is standard input.
///
/// # Errors
/// Names the two.
pub fn check_stdin(inputs: &[Option<Named<'_>>]) -> Result<()> {
    let mut from = inputs.iter().flatten().filter(|(_, path)| is_stdin(path));
    if let (Some((first, _)), Some((second, _))) = (from.next(), from.next()) {
        bail!("{second} -: {first} is standard input already");
    }
    Ok(())
}

/// Makes a folder for pictures, and refuses one in which nothing can be written.
///
/// # Errors
/// Names the option and the folder.
pub fn make_folder((option, path): Named<'_>) -> Result<()> {
    let refusal = || format!("{option} {}: nothing can be written there", path.display());
    std::fs::create_dir_all(path).with_context(refusal)?;
    let name = path.join(format!(".splineway-{}", std::process::id()));
    File::create(&name).and_then(|_| std::fs::remove_file(&name)).with_context(refusal)
}

/// An input or an output by its option, if it was given.
pub fn named<'a>(option: &'a str, path: Option<&'a PathBuf>) -> Option<Named<'a>> {
    path.map(|path| (option, path.as_path()))
}

/// A file's ending must be one of a list.
///
/// # Errors
/// It is not.
pub fn check_ending(file: Option<Named<'_>>, endings: &[&str]) -> Result<()> {
    let Some((option, path)) = file else { return Ok(()) };
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("");
    if !endings.contains(&ending) {
        bail!("{option} {}: it must end in .{}", path.display(), endings.join(", ."));
    }
    Ok(())
}
