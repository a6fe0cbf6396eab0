//! Which build of Cullet solves the jobs of a local run: results of another one may differ in their
//! last bits.

use cullet_pool::Build;
use cullet_proto::JobId;
use cullet_proto::ids::digest;
use std::fs;
use std::path::{Path, PathBuf};

/// The digest of a program, or of this one. One that cannot be read is like no other.
pub(crate) fn build_of(program: Option<&Path>) -> Build {
    let path = program.map(Path::to_owned).or_else(own).or_else(|| std::env::current_exe().ok());
    let bytes = path.and_then(|path| fs::read(path).ok());
    let nobody = || {
        let start = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        let (start, process) = (start.unwrap_or_default().as_nanos(), std::process::id());
        digest(format!("{process} {start}").as_bytes())
    };
    Build(bytes.map_or_else(nobody, |bytes| digest(&bytes)))
}

/// What this program is, in a line: its version, the commit of its sources, and its build, by which
/// farms tell programs apart.
#[must_use]
pub fn describe_version() -> String {
    let (version, commit) = (env!("CARGO_PKG_VERSION"), env!("CULLET_COMMIT"));
    let build = JobId(build_of(None).0).short();
    format!("cullet {version} (commit {commit}, build {build})")
}

/// The file that this code was loaded from: of a program that loads it as a library, such as
/// Python, not the program.
#[cfg(target_os = "linux")]
fn own() -> Option<PathBuf> {
    let here = build_of as *const () as usize;
    let maps = fs::read_to_string("/proc/self/maps").ok()?;
    let line = maps.lines().find(|line| {
        let range = line.split(' ').next().and_then(|range| range.split_once('-'));
        let address = |text: &str| usize::from_str_radix(text, 16).ok();
        let range = range.and_then(|(from, to)| Some(address(from)?..address(to)?));
        range.is_some_and(|range| range.contains(&here))
    })?;
    let path = line.find('/').map(|at| PathBuf::from(&line[at..]))?;
    path.is_file().then_some(path)
}

#[cfg(not(target_os = "linux"))]
fn own() -> Option<PathBuf> {
    None
}

#[cfg(test)]
mod tests {
    use super::{build_of, own};

    #[test]
    fn a_build_is_that_of_the_file_with_this_code() {
        let exe = std::env::current_exe().expect("this program");
        assert_eq!(build_of(None), build_of(Some(&exe)));
        let folder = tempfile::tempdir().expect("a folder");
        let other = folder.path().join("other");
        std::fs::write(&other, "another program").expect("a file");
        assert_ne!(build_of(None), build_of(Some(&other)));
        let none = folder.path().join("none");
        assert_ne!(
            build_of(Some(&none)),
            build_of(Some(&none)),
            "what is not read is like no other"
        );
        if cfg!(target_os = "linux") {
            let same = own().and_then(|path| path.canonicalize().ok());
            assert_eq!(same, exe.canonicalize().ok());
        }
    }
}
