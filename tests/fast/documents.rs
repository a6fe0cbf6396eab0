//! Pages name what is there, are as wide as a screen, and speak of the project alone.

use crate::source::declarations;
use crate::tree::{NamedText, assert_none, check_list, planted, read, sources};
use cullet_tests::root;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

const MAX_COLUMNS: usize = 120;
const MAX_OVERVIEW: usize = 300;
const OVERVIEW: &str = "ARCHITECTURE.md";

/// Paths in pages that are no file of the tree: what a user makes, and keys of other programs. Each
/// line is a page, the name and how often it stands there.
const EXAMPLE_PATHS: &str = include_str!("example_paths.txt");

/// The page that the program writes: its units look like paths.
const GENERATED: &str = "docs/scene.md";

/// What stands between backticks in a page, outside of its blocks of code.
fn quoted(page: &str) -> Vec<String> {
    let mut inside = false;
    let prose = page.lines().filter(|line| {
        let fence = line.trim_start().starts_with("```");
        inside ^= fence;
        !inside && !fence
    });
    let prose = prose.collect::<Vec<_>>().join("\n");
    prose.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// The paths in pages that are none, as a page and a path, and how often each stands there.
fn stale_paths(pages: &[NamedText], exists: &dyn Fn(&str) -> bool) -> BTreeMap<String, usize> {
    let mut found = BTreeMap::new();
    for (page, text) in pages.iter().filter(|(page, _)| page != GENERATED) {
        let folder = page.rsplit_once('/').map_or("", |(folder, _)| folder);
        let elsewhere = ["/", "runs/", "tcp/", "target/"];
        for path in quoted(text) {
            let looks_like_path = path.contains('/')
                && !path.contains(|c: char| c.is_whitespace() || "<>$*{}…=:|\\".contains(c))
                && !elsewhere.iter().any(|start| path.starts_with(start));
            let name = path.trim_end_matches('/');
            let places = [
                name.to_owned(),
                format!("services/{name}"),
                format!("services/{name}.rs"),
                format!("{folder}/{name}"),
            ];
            if looks_like_path && !places.iter().any(|place| exists(place)) {
                *found.entry(format!("{page} {path}")).or_default() += 1;
            }
        }
    }
    found
}

/// Tests that pages name and that are nowhere: `path.rs::name`, and names such as `f22_name`.
fn check_tests(pages: &[NamedText], sources: &[NamedText]) -> Vec<String> {
    let functions = |text: &str| -> BTreeSet<String> {
        declarations(text, "fn").into_iter().map(|(_, name)| name.to_owned()).collect()
    };
    let in_files: BTreeMap<&str, BTreeSet<String>> =
        sources.iter().map(|(name, text)| (name.as_str(), functions(text))).collect();
    let numbered = |name: &str| {
        let rest = name.strip_prefix(['f', 't', 'r']).unwrap_or("");
        let digits = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        digits.len() < rest.len() && digits.trim_start_matches('m').starts_with('_')
    };
    let mut faults = Vec::new();
    for (page, text) in pages {
        for name in quoted(text).iter().filter(|name| !name.contains(char::is_whitespace)) {
            let there = match name.split_once(".rs::") {
                Some((file, test)) => {
                    let test = test.rsplit("::").next().unwrap_or(test);
                    in_files
                        .get(format!("{file}.rs").as_str())
                        .is_some_and(|all| all.contains(test))
                }
                None if numbered(name) => in_files.values().any(|all| all.contains(name)),
                None => true,
            };
            if !there {
                faults.push(format!("{page} names `{name}`, which is no test"));
            }
        }
    }
    faults
}

/// Lines of pages that are too wide.
fn check_columns(pages: &[NamedText]) -> Vec<String> {
    let lines = pages.iter().flat_map(|(page, text)| {
        text.lines().enumerate().map(move |(at, line)| (page, at + 1, line.chars().count()))
    });
    let wide = lines.filter(|(.., width)| *width > MAX_COLUMNS);
    wide.map(|(page, line, width)| format!("{page}:{line} is {width} columns wide")).collect()
}

/// An overview that is too long to be one.
fn check_overview(pages: &[NamedText]) -> Vec<String> {
    let lines = |text: &str| text.lines().count();
    let long = pages.iter().filter(|(page, text)| page == OVERVIEW && lines(text) > MAX_OVERVIEW);
    let text = |(page, text): &NamedText| {
        format!("{page} is a bird's eye: {} lines, at most {MAX_OVERVIEW}", lines(text))
    };
    long.map(text).collect()
}

/// Commands of a justfile that a page does not name.
fn check_commands(justfile: &str, page: &str) -> Vec<String> {
    let calls = justfile.lines().filter_map(|line| line.strip_prefix("    "));
    let unnamed =
        calls.filter(|call| !call.starts_with('@') && !page.contains(&format!("`{call}`")));
    unnamed.map(|call| format!("CONTRIBUTING.md does not name `{call}`")).collect()
}

/// Files that speak of folders of one machine.
fn check_machines(texts: &[NamedText]) -> Vec<String> {
    let banned = ["root", "home"].map(|folder| format!("/{folder}/"));
    let speaks = |(name, text): &NamedText| {
        let word = banned.iter().find(|word| text.contains(*word))?;
        Some(format!("{name} speaks of `{word}`"))
    };
    texts.iter().filter_map(speaks).collect()
}

#[test]
fn documents_name_real_paths() {
    let root = root();
    let pages = read(&[".md"]);
    assert!(pages.len() > 30, "{}", pages.len());
    let found = stale_paths(&pages, &|path| root.join(path).exists());
    let list = ("tests/fast/example_paths.txt", EXAMPLE_PATHS);
    assert_none(&check_list(list, &found, "there is no such file"));
    assert!(pages.iter().any(|(page, _)| page == OVERVIEW));
    assert_none(&check_overview(&pages));
}

#[test]
fn documents_name_real_tests() {
    assert_none(&check_tests(&read(&[".md"]), sources()));
}

#[test]
fn documents_fit_on_a_screen() {
    assert_none(&check_columns(&read(&[".md"])));
}

/// `just` is a convenience: whoever does not have it reads the same commands.
#[test]
fn the_justfile_calls_what_contributing_names() {
    let text = |name| fs::read_to_string(root().join(name)).expect("a file of the root");
    let justfile = text("justfile");
    assert!(justfile.lines().filter(|line| line.starts_with("    ")).count() >= 5, "{justfile}");
    assert_none(&check_commands(&justfile, &text("CONTRIBUTING.md")));
}

#[test]
fn the_project_speaks_of_itself_alone() {
    assert_none(&check_machines(&read(&[".rs", ".md", ".toml", ".py", ".json", "run"])));
}

#[test]
fn stale_names_are_found() {
    let text = "`services/world` and `world/src`, `gone/file.rs`, `beside/it.md`, `runs/1`\n```\n\
                `in/block`\n```\n`gone/file.rs` and `m/s now`";
    let pages = planted([("docs/a.md", text), (GENERATED, "`m/s`")]);
    let there = ["services/world", "services/world/src", "docs/beside/it.md"];
    let found = stale_paths(&pages, &|path| there.contains(&path));
    assert_eq!(found, [("docs/a.md gone/file.rs".to_owned(), 2)].into());
    let text =
        "`tests/a.rs::f01_one`, `tests/a.rs::f02_two`, `f01_one`, `f03_three`, `f90m_four`, `f64`";
    let sources =
        planted([("tests/a.rs", "#[test]\nfn f01_one() {}"), ("b.rs", "fn f02_two() {}")]);
    let said = check_tests(&planted([("docs/a.md", text)]), &sources);
    let names = ["tests/a.rs::f02_two", "f03_three", "f90m_four"];
    assert_eq!(said, names.map(|name| format!("docs/a.md names `{name}`, which is no test")));
}

#[test]
fn wide_and_long_pages_and_foreign_folders_are_found() {
    let wide = format!("# A\n\n{}\n{}", "\u{3c3}".repeat(MAX_COLUMNS), "a".repeat(MAX_COLUMNS + 1));
    assert_eq!(check_columns(&planted([("a.md", &wide)])), ["a.md:4 is 121 columns wide"]);
    let long = "a\n".repeat(MAX_OVERVIEW + 1);
    let said = check_overview(&planted([(OVERVIEW, &long), ("README.md", &long)]));
    assert_eq!(said, ["ARCHITECTURE.md is a bird's eye: 301 lines, at most 300"]);
    let folder = format!("see /{}/me", "home");
    let said = check_machines(&planted([("a.md", &folder), ("b.md", "at home/")]));
    assert_eq!(said, [format!("a.md speaks of `/{}/`", "home")]);
}

#[test]
fn commands_without_a_name_are_found() {
    let justfile = "build:\n    cargo build\n    @echo\ntest:\n    cargo test\n";
    let said = check_commands(justfile, "`cargo build` builds");
    assert_eq!(said, ["CONTRIBUTING.md does not name `cargo test`"]);
}
