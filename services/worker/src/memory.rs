//! How much memory a job may hold where nobody says: what the machine has, or the container or unit
//! that this process is in, less a reserve for all else, shared among the jobs that are solved
//! there at once.

use std::fs;
use std::path::Path;

/// Kept for all else: an eighth, or this \[bytes\], or half where there is little.
const RESERVE: u64 = 512 << 20;
/// No job is held to less than this \[bytes\], as long as there is as much: on a machine of many
/// cores not every worker has a large job at once, and one that has is no harm.
const LEAST: u64 = 2 << 30;

/// Where limits of groups of processes are found.
const GROUPS: &str = "/sys/fs/cgroup";

/// The limit of each of so many jobs at once \[bytes\]; nothing where the system does not say what
/// there is.
#[must_use]
pub fn share(jobs: usize) -> Option<u64> {
    whole().map(|whole| part(whole, jobs))
}

/// Memory that there is for this process and its children \[bytes\].
fn whole() -> Option<u64> {
    let machine = machine(&fs::read_to_string("/proc/meminfo").ok()?)?;
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let read = |path: &str| fs::read_to_string(Path::new(GROUPS).join(path)).ok();
    Some(group(&groups, read).map_or(machine, |group| group.min(machine)))
}

fn machine(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib << 10)
}

/// The least limit of the groups that a process is in, which are named in `text`; `read` gives a
/// file below their root. Of a group in a container its own path may not be there: then the root
/// is it.
fn group(text: &str, read: impl Fn(&str) -> Option<String>) -> Option<u64> {
    let mut least: Option<u64> = None;
    for line in text.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(kind), Some(path)) = (parts.next(), parts.next()) else { continue };
        let (root, file) = match kind {
            "" => ("", "memory.max"),
            _ if kind.split(',').any(|kind| kind == "memory") => {
                ("memory/", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        let own = Path::new(path.trim_start_matches('/'));
        for place in own.ancestors() {
            let file = format!("{root}{}", place.join(file).display());
            // Without a limit it is `max`, or a number beyond all machines.
            let limit = read(&file).and_then(|text| text.trim().parse().ok());
            least = least.into_iter().chain(limit).min();
        }
    }
    least
}

fn part(whole: u64, jobs: usize) -> u64 {
    let reserve = (whole / 8).max(RESERVE.min(whole / 2));
    let room = whole - reserve;
    (room / jobs.max(1) as u64).max(room.min(LEAST))
}

#[cfg(test)]
mod tests {
    use super::{group, machine, part, share};

    const GIB: u64 = 1 << 30;

    #[test]
    fn a_job_gets_its_part_and_never_so_little_that_it_cannot_live() {
        assert_eq!(part(24 * GIB, 1), 21 * GIB);
        assert_eq!(part(24 * GIB, 3), 7 * GIB);
        // A pod of 4 GiB, one of 1 GiB, one of 512 MiB.
        assert_eq!(part(4 * GIB, 1), 3584 << 20);
        assert_eq!(part(GIB, 1), 512 << 20);
        assert_eq!(part(GIB / 2, 1), 256 << 20);
        // Many cores, little memory: two jobs of 2 GiB are there beside small ones.
        assert_eq!(part(24 * GIB, 64), 2 * GIB);
        assert_eq!(part(2 * GIB, 64), 1536 << 20);
        assert_eq!(part(GIB, 0), part(GIB, 1));
        // What is kept is never touched by one job.
        for mib in [1, 100, 1000, 10_000, 1_000_000] {
            assert!(part(mib << 20, 1) <= (mib << 20) - (mib << 17), "{mib}");
        }
        assert!(share(1).is_none_or(|bytes| bytes >= share(2).unwrap_or(0) && bytes > 0));
    }

    #[test]
    fn the_machine_says_what_it_has() {
        let text = "MemTotal:       24532100 kB\nMemFree:  100 kB\n";
        assert_eq!(machine(text), Some(24_532_100 << 10));
        assert_eq!(machine("MemFree: 100 kB\n"), None);
        assert_eq!(machine("MemTotal: many\n"), None);
    }

    #[test]
    fn the_least_limit_of_all_groups_counts() {
        let files = [
            ("memory.max", "max\n"),
            ("farm.slice/memory.max", "4294967296\n"),
            ("farm.slice/worker/memory.max", "max\n"),
            ("memory/memory.limit_in_bytes", "9223372036854771712\n"),
            ("memory/pod/memory.limit_in_bytes", "1073741824\n"),
        ];
        let read = |path: &str| {
            let found = files.iter().find(|(name, _)| *name == path);
            found.map(|(_, text)| (*text).to_owned())
        };
        assert_eq!(group("0::/farm.slice/worker\n", read), Some(4 * GIB));
        assert_eq!(group("0::/elsewhere\n", read), None);
        let old = "12:cpu,cpuacct:/x\n4:memory:/pod\n1:name=systemd:/y\n";
        assert_eq!(group(old, read), Some(GIB));
        assert_eq!(group("4:memory:/\n", read), Some(9_223_372_036_854_771_712));
        assert_eq!(group("garbage", read), None);
    }
}
