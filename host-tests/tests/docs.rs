//! What the documentation names exists: relative links of README and `docs`, every path in the tables of
//! `docs/house.md`, and what commands within the text are about. (Those in blocks are run, by `.ci/commands.py`.)

use clap::CommandFactory;
use splineway_host::commands::Arguments;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// README and every page of `docs`.
fn pages() -> Vec<PathBuf> {
    let mut pages = vec![root().join("README.md")];
    for entry in fs::read_dir(root().join("docs")).unwrap() {
        let page = entry.unwrap().path();
        if page.extension().is_some_and(|ending| ending == "md") {
            pages.push(page);
        }
    }
    assert!(pages.len() > 5, "{pages:?}");
    pages
}

/// Targets of the links of a page: what stands in `](...)`.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target)
}

/// The anchor of a heading, as the usual renderers make it.
fn anchor(heading: &str) -> String {
    let letters = heading.trim().to_lowercase();
    letters
        .chars()
        .filter(|letter| letter.is_alphanumeric() || " -_".contains(*letter))
        .map(|letter| if letter == ' ' { '-' } else { letter })
        .collect()
}

fn has_anchor(text: &str, wanted: &str) -> bool {
    let headings = text.lines().filter_map(|line| line.strip_prefix('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).any(|name| name == wanted)
}

#[test]
fn relative_links_lead_somewhere() {
    let mut broken = Vec::new();
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for link in links(&text).filter(|link| !link.contains("://")) {
            let (file, wanted) = link.split_once('#').unwrap_or((link, ""));
            let target =
                if file.is_empty() { page.clone() } else { page.with_file_name("").join(file) };
            let exists = target.exists();
            if !exists
                || !wanted.is_empty() && !has_anchor(&fs::read_to_string(&target).unwrap(), wanted)
            {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn every_path_of_the_house_exists() {
    let page = fs::read_to_string(root().join("docs/house.md")).unwrap();
    let code = page.lines().filter(|line| line.starts_with('|'));
    let paths: Vec<&str> = code
        .flat_map(|line| line.split('`').skip(1).step_by(2))
        .filter(|name| {
            name.chars().all(|letter| letter.is_lowercase() || "/-_.0123456789".contains(letter))
        })
        .collect();
    assert!(paths.len() > 30, "{paths:?}");
    let missing: Vec<&&str> = paths.iter().filter(|path| !root().join(path).exists()).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

/// A folder of the core or a package that nobody is told of.
#[test]
fn every_folder_of_the_core_is_in_the_table() {
    let page = fs::read_to_string(root().join("docs/house.md")).unwrap();
    for entry in fs::read_dir(root().join("src")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(!path.is_dir() || page.contains(&format!("| `src/{name}` |")), "src/{name}");
    }
}

#[test]
fn the_readme_is_short() {
    let words = fs::read_to_string(root().join("README.md")).unwrap().split_whitespace().count();
    assert!(words <= 600, "{words} words");
}

/// What stands between single backquotes, out of blocks.
fn codes(text: &str) -> Vec<&str> {
    let mut inside = false;
    let mut all = Vec::new();
    for line in text.lines() {
        if line.starts_with("```") {
            inside = !inside;
        } else if !inside {
            all.extend(line.split('`').skip(1).step_by(2));
        }
    }
    all
}

/// What is wrong with a command of the program: its name, or an option that it does not have.
fn wrong_in(words: &[&str]) -> Option<String> {
    let program = Arguments::command();
    let name = words.first()?;
    let Some(command) = program.find_subcommand(name) else {
        return Some(format!("no command {name}"));
    };
    let options = words.iter().filter_map(|word| word.trim_matches(['[', ']']).strip_prefix("--"));
    let has = |option: &&str| command.get_arguments().any(|own| own.get_long() == Some(*option));
    options
        .into_iter()
        .find(|option| !has(option))
        .map(|option| format!("{name} has no --{option}"))
}

/// What is wrong with a command of cargo: the package, test, bench or example that it names.
fn wrong_for_cargo(words: &[&str]) -> Option<String> {
    let host = root().join("host-tests");
    let own = words.iter().position(|word| *word == "--");
    if let Some(behind) = own
        && words.contains(&"splineway-host")
        && words.contains(&"run")
        && !words.contains(&"--example")
        && words.get(behind + 1) != Some(&"COMMAND")
    {
        return wrong_in(&words[behind + 1..]);
    }
    for pair in words.windows(2) {
        let (option, name) = (pair[0], pair[1]);
        let places = match option {
            "--test" => vec![host.join(format!("tests/{name}.rs"))],
            "--bench" => {
                vec![
                    host.join(format!("benches/{name}.rs")),
                    host.join(format!("benches/{name}/main.rs")),
                ]
            }
            "--example" => vec![
                host.join(format!("examples/{name}.rs")),
                root().join(format!("examples/{name}.rs")),
            ],
            _ => continue,
        };
        if !places.iter().any(|place| place.exists()) {
            return Some(format!("no {} {name}", &option[2..]));
        }
    }
    None
}

/// Commands within the text: what they name is there.
#[test]
fn commands_in_the_text_are_there() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for code in codes(&text) {
            let words: Vec<&str> = code.split_whitespace().collect();
            let found = match words.as_slice() {
                ["splineway", rest @ ..] => wrong_in(rest),
                ["cargo", "sim", rest @ ..] if rest != ["COMMAND"] => wrong_in(rest),
                ["cargo", rest @ ..] => wrong_for_cargo(rest),
                _ => continue,
            };
            count += 1;
            wrong.extend(found.map(|what| format!("{}: `{code}`: {what}", page.display())));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(count > 30, "{count} commands");
}

/// What does not name anything is found.
#[test]
fn commands_that_are_not_there_are_found() {
    for (words, what) in [
        (&["simulate", "FILE", "--plots"][..], "simulate has no --plots"),
        (&["dance"], "no command dance"),
        (&["soak", "[--cases", "N]"], ""),
        (&[], ""),
    ] {
        assert_eq!(wrong_in(words).unwrap_or_default(), what);
    }
    for (words, what) in [
        (&["test", "--test", "nothing"][..], "no test nothing"),
        (&["bench", "--bench", "target"], ""),
        (&["run", "-p", "splineway-host", "--", "dance"], "no command dance"),
    ] {
        assert_eq!(wrong_for_cargo(words).unwrap_or_default(), what);
    }
}

/// The machine of the page is one that runs.
#[test]
fn the_machine_of_the_page_is_accepted() {
    let page =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/formats.md")).unwrap();
    let machines = page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    for text in machines.clone() {
        let machine = splineway_simulator::machine::Machine::parse(text)
            .unwrap_or_else(|error| panic!("{error:#}: {text}"));
        machine.config::<f64, 3>(&[0, 1, 2]).unwrap();
    }
    assert_eq!(machines.count(), 1);
}
