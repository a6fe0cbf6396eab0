//! What a change can reach: from the files that changed and from the table of who may use whom to
//! the suites that must run. Whatever is in doubt runs, but of the scenes those that stand for a
//! family, and of long series those of crates that changed themselves.

use crate::house::MAY_USE;
use std::collections::BTreeSet;

/// A scene and the family of solvers or the feature that it stands for. Each family is there once.
pub const SCENES: [(&str, &str); 12] = [
    ("pot", "brittle"),
    ("bulb", "shell"),
    ("shower", "toughened glass"),
    ("windscreen", "laminated glass"),
    ("can", "sheet metal"),
    ("lead_soldier", "ductile"),
    ("panels", "peridynamics"),
    ("mortar", "geometric"),
    ("towel", "membrane"),
    ("garment", "soft-shell"),
    ("jelly", "soft-solid"),
    ("vases", "directed pieces"),
];

/// Crates that the farm's long tests are about.
const POOL: [&str; 7] = [
    "proto",
    "services/coordinator",
    "services/dispatch",
    "services/pool",
    "services/record",
    "services/tls",
    "services/worker",
];

/// Where long tests of the suites over the program are, as a filter of `cargo nextest`, and the
/// crates whose own change runs them. One is marked `#[ignore = "long"]`; `.ci/full` runs all.
pub const LONG: [(&str, &[&str]); 4] = [
    ("binary_id(cullet::farm)", &POOL),
    ("test(/^coupling::/)", &["services/coordinator", "services/plan", "services/world"]),
    ("test(/^fidelity::/)", &["services/coordinator", "services/plan"]),
    ("test(/^specimens::/)", &["services/fracture", "services/specimen"]),
];

/// Crates that nearly everything is made of, by folder: a change of one reaches all.
const FOUNDATION: [&str; 3] = ["proto", "services/model", "services/geometry"];

/// What must run for a change.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reach {
    /// Why all suites must run, if they must.
    pub everything: Option<String>,
    /// Folders of the crates that changed.
    pub changed: BTreeSet<String>,
    /// Folders of the crates that the change reaches.
    pub crates: BTreeSet<String>,
    /// Tests of scenes that changed, as `scenes::NAME` has them.
    pub scenes: BTreeSet<String>,
    /// Whether files of the stability suite changed.
    pub stability: bool,
    /// Whether files of the farm's suites changed.
    pub farm: bool,
    /// Whether files of the suites over the program changed.
    pub verification: bool,
    /// Whether the package for Python must be tested.
    pub wheel: bool,
    /// Whether exports and pages must be read by programs from elsewhere.
    pub exports: bool,
}

impl Reach {
    /// What files that changed, by path from the root, can reach.
    #[must_use]
    pub fn of<'a>(changed: impl IntoIterator<Item = &'a str>) -> Self {
        let mut reach = Self::default();
        for path in changed {
            reach.add(path);
        }
        reach.close();
        reach
    }

    /// Everything, for a reason.
    #[must_use]
    pub fn everything(reason: &str) -> Self {
        Self { everything: Some(reason.to_owned()), wheel: true, exports: true, ..Self::default() }
    }

    fn add(&mut self, path: &str) {
        let mut parts = path.split('/');
        let (head, next) = (parts.next().unwrap_or(""), parts.next().unwrap_or(""));
        match (head, next) {
            (_, _) if path.ends_with(".md") && head != "services" => {
                self.wheel |= path == "docs/tutorials/python.md";
            }
            ("docs" | "deploy", _) | ("tests", "fast" | "smoke") | (".ci", "green") => {}
            ("tests", "farm") => self.farm = true,
            ("justfile" | "_typos.toml" | ".editorconfig" | ".gitignore", "") => {}
            (name, "") if name.starts_with("LICENSE") => {}
            ("scenes", name) if parts.next().is_some() => {
                self.scenes.insert(name.replace('-', "_"));
            }
            ("tests", "stability") => self.stability = true,
            ("tests", "verification" | "specimens" | "frontier") => self.verification = true,
            ("tests", "python") => self.exports = true,
            ("services", "python") => self.wheel = true,
            ("services", name) => {
                self.crates.insert(format!("services/{name}"));
            }
            ("proto", _) => {
                self.crates.insert("proto".to_owned());
            }
            _ => self.everything = Some(format!("{path} changed")),
        }
    }

    /// Adds who uses what is reached, until nobody is added.
    fn close(&mut self) {
        self.changed.clone_from(&self.crates);
        if let Some(at) = FOUNDATION.into_iter().find(|at| self.crates.contains(*at)) {
            self.everything = Some(format!("{at} changed, which nearly everything is made of"));
        }
        loop {
            let users = MAY_USE.iter().filter(|(folder, uses)| {
                !self.crates.contains(*folder) && uses.iter().any(|name| self.has(name))
            });
            let users: Vec<String> = users.map(|(folder, _)| (*folder).to_owned()).collect();
            if users.is_empty() {
                break;
            }
            self.crates.extend(users);
        }
        self.wheel |= self.has("run") || self.has("record") || self.has("export");
        self.exports |= self.has("export") || self.has("web") || self.has("view");
        if self.everything.is_some() {
            (self.wheel, self.exports) = (true, true);
        }
    }

    /// Whether a crate is reached.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.crates.contains(&format!("services/{name}")) || self.crates.contains(name)
    }

    /// The tests to run, as a filter of `cargo nextest`. The smoke suite is not among them: it is
    /// part of the command that README names.
    #[must_use]
    pub fn tests(&self) -> String {
        let scenes = SCENES.iter().map(|(name, _)| *name);
        let scenes: Vec<&str> = scenes.chain(self.scenes.iter().map(String::as_str)).collect();
        let scenes = format!("test(/^scenes::(.*::)?({})$/)", scenes.join("|"));
        let scenes = format!("(package(cullet) & binary(verification) & {scenes})");
        format!("{} | {scenes}", self.suites().join(" | "))
    }

    /// The long tests to run, as a filter of `cargo nextest`: those of crates that changed
    /// themselves, and those of suites over the program that changed or that are about such crates.
    #[must_use]
    pub fn long_tests(&self) -> String {
        let runs = |tests: &str, crates: &[&str]| {
            crates.iter().any(|folder| self.changed.contains(*folder))
                || (self.verification && tests.starts_with("test("))
                || (self.farm && tests.starts_with("binary_id("))
        };
        let any = LONG.into_iter().filter(|(tests, crates)| runs(tests, crates));
        let any: Vec<&str> = any.map(|(tests, _)| tests).collect();
        if any.is_empty() { "none()".to_owned() } else { any.join(" | ") }
    }

    /// Suites to run, besides scenes, as filters.
    fn suites(&self) -> Vec<String> {
        let mut any = vec!["binary(farm)".to_owned()];
        if self.everything.is_some() {
            any.push("(binary(verification) - (package(cullet) & test(/^scenes::/)))".to_owned());
            return any;
        }
        for family in ["fracture", "shell", "peridynamics", "membrane"] {
            if self.has(family) {
                any.push(format!("(package(cullet-{family}) & binary(verification))"));
            }
        }
        let solved = self.has("worker") || self.has("scene") || self.has("lab");
        if self.stability || solved {
            any.push("(package(cullet-tests) & binary(verification))".to_owned());
        }
        if self.verification || solved {
            let suites = "package(cullet) & binary(verification) - test(/^scenes::/)";
            any.push(format!("({suites})"));
        }
        any
    }

    /// Folders of the scenes to run and export.
    #[must_use]
    pub fn folders_of_scenes(&self) -> Vec<String> {
        let names = SCENES.iter().map(|(name, _)| *name);
        let all: BTreeSet<&str> = names.chain(self.scenes.iter().map(String::as_str)).collect();
        all.into_iter().map(|name| name.replace('_', "-")).collect()
    }

    /// What is left out, in words: at least the scenes that stand for no family, which only
    /// `.ci/full` runs.
    #[must_use]
    pub fn left_out(&self) -> String {
        let others =
            "scenes that stand for no family, long tests of what did not change".to_owned();
        if self.everything.is_some() {
            return others;
        }
        let mut out = Vec::new();
        for family in ["fracture", "shell", "peridynamics", "membrane"] {
            if !self.has(family) {
                out.push(format!("verification of {family}"));
            }
        }
        let solved = self.has("worker") || self.has("scene") || self.has("lab");
        if !(solved || self.stability) {
            out.push("stability".to_owned());
        }
        if !(solved || self.verification) {
            out.push("benchmarks and other suites over the program".to_owned());
        }
        out.push(others);
        if !self.wheel {
            out.push("the package for Python and its notebooks".to_owned());
        }
        if !self.exports {
            out.push("exports and pages in other programs".to_owned());
        }
        out.join(", ")
    }
}
