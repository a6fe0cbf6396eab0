//! Memory of processes, as the system tells it.

/// What the system tells of a process's memory under that word \[bytes\], if it does.
pub fn of_process(process: &str, what: &str) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(what))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib << 10)
}
