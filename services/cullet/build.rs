//! What the program is told when it is built: the commit of its sources, and the scenes that are
//! shipped. Without a repository or without git the commit is unknown; packagers name it in
//! `CULLET_COMMIT`. No path of the machine that builds gets into the program.
//!
//! Functions with the same code are linked once where the linker is the compiler's own, which makes
//! the program smaller. Nothing here compares addresses of functions.

use std::env;
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where packagers name the commit, and where the sources read it.
const COMMIT: &str = "CULLET_COMMIT";
/// What a commit is called that nobody knows.
const UNKNOWN: &str = "unknown";
/// What the program is made of, as git names it: where one of these differs from the commit, the
/// program is not that commit's.
const SOURCES: [&str; 8] = [
    "Cargo.toml",
    "Cargo.lock",
    "proto",
    "scenes",
    "services/*/Cargo.toml",
    "services/*/src/*",
    "services/*/assets/*",
    "services/cullet/build.rs",
];

fn main() -> io::Result<()> {
    let own = env::var_os("CARGO_MANIFEST_DIR").ok_or(io::ErrorKind::NotFound)?;
    let root = Path::new(&own).join("../..");
    println!("cargo:rerun-if-env-changed={COMMIT}");
    let named = env::var(COMMIT).ok().filter(|commit| !commit.is_empty());
    let commit = named.or_else(|| read_commit(&root)).unwrap_or_else(|| UNKNOWN.to_owned());
    println!("cargo:rustc-env={COMMIT}={commit}");
    let table = list_scenes(&root.join("scenes"))?;
    let out = env::var_os("OUT_DIR").ok_or(io::ErrorKind::NotFound)?;
    if links_with_lld() {
        println!("cargo:rustc-link-arg-bins=-Wl,--icf=all");
    }
    fs::write(Path::new(&out).join("shipped.rs"), table)
}

/// Whether the linker is the one that the compiler brings, which on x86-64 Linux is LLD.
fn links_with_lld() -> bool {
    let target = env::var("TARGET").is_ok_and(|target| target == "x86_64-unknown-linux-gnu");
    let flags = env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    target && env::var_os("RUSTC_LINKER").is_none() && !flags.contains("link")
}

/// What git answers, if there is git.
fn ask_git(root: &Path, arguments: &[&str]) -> Option<String> {
    let mut git = Command::new("git");
    git.arg("-C").arg(root).args(arguments).env("GIT_OPTIONAL_LOCKS", "0");
    let answer = git.output().ok()?;
    let text = answer.status.success().then(|| String::from_utf8(answer.stdout).ok())??;
    Some(text.trim_end().to_owned())
}

/// The commit that is checked out, marked where the sources differ from it. It is asked for again
/// after a commit, after a checkout, and after a change of what the program is made of.
fn read_commit(root: &Path) -> Option<String> {
    // A repository of others, in which a copy of the sources lies, is not asked.
    if !root.join(".git").exists() {
        return None;
    }
    let commit = ask_git(root, &["rev-parse", "--short=8", "HEAD"])?;
    let place = |name: &str| ask_git(root, &["rev-parse", "--git-path", name]);
    let mut watched: Vec<PathBuf> =
        ["HEAD", "packed-refs"].into_iter().filter_map(place).map(|path| root.join(path)).collect();
    watched.retain(|path| path.exists());
    let branch = ask_git(root, &["symbolic-ref", "--quiet", "HEAD"]);
    let branch = branch.and_then(|name| place(&name)).map(|path| root.join(path));
    // A branch among the packed ones has no file yet: with it, its folder changes.
    let branch = branch.as_deref().and_then(|path| path.ancestors().find(|path| path.exists()));
    watched.extend(branch.map(Path::to_owned));
    let files = ask_git(root, &[&["ls-files", "--"][..], &SOURCES].concat())?;
    watched.extend(files.lines().map(|file| root.join(file)).filter(|file| file.exists()));
    for path in watched {
        println!("cargo:rerun-if-changed={}", path.display());
    }
    let changed = ask_git(root, &[&["status", "--porcelain", "--"][..], &SOURCES].concat())?;
    Some(if changed.is_empty() { commit } else { commit + "-changed" })
}

/// The scenes as the source of a table: each folder that has a `scene.toml`, with all its files.
fn list_scenes(folder: &Path) -> io::Result<String> {
    println!("cargo:rerun-if-changed={}", folder.display());
    let mut table = String::from("pub(crate) static SHIPPED: &[ShippedScene] = &[\n");
    for scene in names_in(folder)? {
        let files = folder.join(&scene);
        if !files.join("scene.toml").is_file() {
            continue;
        }
        let _ = writeln!(table, "ShippedScene {{ name: {scene:?}, files: &[");
        for name in names_in(&files)?.iter().filter(|name| files.join(name).is_file()) {
            let path = format!("/../../scenes/{scene}/{name}");
            let bytes = format!("include_bytes!(concat!(env!(\"CARGO_MANIFEST_DIR\"), {path:?}))");
            let _ = writeln!(table, "ShippedFile {{ name: {name:?}, bytes: {bytes} }},");
        }
        table.push_str("] },\n");
    }
    table.push_str("];\n");
    Ok(table)
}

/// What lies in a folder, by name; hidden files are nobody's.
fn names_in(folder: &Path) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder)? {
        names.extend(entry?.file_name().into_string().ok().filter(|name| !name.starts_with('.')));
    }
    names.sort();
    Ok(names)
}
