//! A page that was written, in the browser.

use anyhow::{Result, ensure};
use splineway_simulator::input::is_stdin;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where the page of a program goes if nobody says where: a file of its own in the folder for temporary files.
pub fn place(program: &Path) -> PathBuf {
    let name = program.file_stem().unwrap_or_default().to_string_lossy();
    let name = if is_stdin(program) { "program" } else { &*name };
    std::env::temp_dir().join(format!("splineway-{name}-{}.html", std::process::id()))
}

/// Programs that open pages, as systems call them, with what they take before the page. (A library for this brings thirty others.)
const OPENERS: &[&[&str]] = if cfg!(target_os = "macos") {
    &[&["open"]]
} else if cfg!(windows) {
    &[&["rundll32", "url.dll,FileProtocolHandler"]]
} else {
    &[&["xdg-open"], &["wslview"], &["gio", "open"], &["sensible-browser"]]
};

/// Opens a page with the program that opens pages on this computer, and does not wait for it.
///
/// # Errors
/// There is none; the message says where the page is.
pub fn show(page: &Path) -> Result<()> {
    let page = std::path::absolute(page).unwrap_or_else(|_| page.to_owned());
    let opens = |opener: &&&[&str]| {
        let mut command = Command::new(opener[0]);
        command.args(&opener[1..]).arg(&page);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().is_ok()
    };
    let opened = OPENERS.iter().find(opens);
    ensure!(opened.is_some(), "no program opens pages here; the page is {}", page.display());
    Ok(())
}
