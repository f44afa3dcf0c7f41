//! The tool paths of our own making, as files: what every bench runs that is not told other ones.
//!
//! `cargo run --release -p splineway-host --example paths -- FOLDER [BYTES]` writes the poly-lines, `pocket.ngc` of 40,000 lines, and
//! `relief.ngc` of so many bytes if they are named.

use anyhow::{Context, Result};
use splineway_studies::paths;
use std::fs;
use std::io::BufWriter;
use std::path::PathBuf;

fn main() -> Result<()> {
    let mut words = std::env::args().skip(1);
    let folder = PathBuf::from(words.next().context("which folder?")?);
    fs::create_dir_all(&folder)?;
    for made in paths::all()? {
        fs::write(folder.join(made.file_name()), made.text())?;
    }
    fs::write(folder.join("pocket.ngc"), paths::pocket())?;
    if let Some(bytes) = words.next() {
        let bytes = bytes.parse().with_context(|| format!("\"{bytes}\" is no number of bytes"))?;
        let mut file = BufWriter::new(fs::File::create(folder.join("relief.ngc"))?);
        paths::relief(&mut file, bytes)?;
        file.into_inner().context("relief.ngc")?.sync_all()?;
    }
    println!("written to {}", folder.display());
    Ok(())
}
