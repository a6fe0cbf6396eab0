//! `reach BASE`: what the difference between a commit and the working tree can reach, as variables
//! for a shell. Without a base, or where the difference cannot be had, everything.

use cullet_tests::reach::Reach;
use cullet_tests::root;
use std::process::Command;

fn main() {
    let reach = match std::env::args().nth(1) {
        Some(base) => since(&base).unwrap_or_else(|reason| Reach::everything(&reason)),
        None => Reach::everything("there is no commit to compare with"),
    };
    let quoted = |text: &str| format!("'{}'", text.replace('\'', "'\\''"));
    let lines = [
        format!("everything={}", quoted(reach.everything.as_deref().unwrap_or(""))),
        format!("tests={}", quoted(&reach.tests())),
        format!("long={}", quoted(&reach.long_tests())),
        format!("scenes={}", quoted(&reach.folders_of_scenes().join(" "))),
        format!("left_out={}", quoted(&reach.left_out())),
        format!("wheel={}", u8::from(reach.wheel)),
        format!("exports={}", u8::from(reach.exports)),
    ];
    println!("{}", lines.join("\n"));
}

/// What changed since a commit, with what is not committed.
fn since(base: &str) -> Result<Reach, String> {
    let changed = git(&["diff", "--name-only", "--no-renames", base])?;
    let new = git(&["ls-files", "--others", "--exclude-standard"])?;
    Ok(Reach::of(changed.lines().chain(new.lines())))
}

fn git(args: &[&str]) -> Result<String, String> {
    let output = Command::new("git").arg("-C").arg(root()).args(args).output();
    match output {
        Ok(output) if output.status.success() => {
            Ok(String::from_utf8_lossy(&output.stdout).into_owned())
        }
        _ => Err(format!("git {} failed", args.join(" "))),
    }
}
