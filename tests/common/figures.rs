//! Figures that a command prints, and the gates that it holds them to.

/// A number that the environment may name.
pub(crate) fn number(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// Says what was measured \[s\]; the middle one.
pub(crate) fn tell(what: &str, mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    let (middle, last) = (all[all.len() / 2], all[all.len() - 1]);
    println!("{what}: median {middle:.3} s, most {last:.3} s of {}", all.len());
    middle
}

/// What took so long \[s\] must take no longer, where figures are wanted: `CULLET_REPEATS` is set.
/// Nothing else is held to a time, for a machine may do much else.
pub(crate) fn gate(took: f64, most: f64) {
    let strict = std::env::var_os("CULLET_REPEATS").is_some();
    assert!(!strict || took <= most, "{took} s, and {most} s is the gate");
}
