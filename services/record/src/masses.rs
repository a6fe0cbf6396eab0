//! How the masses of fragments are distributed: the list, and two laws fitted to it (G2).

use super::{RecordError, Recording};
use cullet_files::cells::quote_cell;
use cullet_model::FragmentOrigin;
use cullet_proto::recording::EventKind;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

/// Cells from which on a solved fragment is resolved \[1\]: the masses of smaller ones depend on
/// the grid. Fragments that were drawn from a law or directed are never resolved, whatever their
/// size.
pub const RESOLVED_CELLS: f64 = 64.0;

/// A fragment that broke no further.
#[derive(Clone, Debug, PartialEq)]
pub struct FragmentMass {
    /// Its name.
    pub name: String,
    /// The object of the scene that it is a part of.
    pub object: String,
    /// How many fractures lie between it and the object.
    pub generation: u32,
    /// Mass \[kg\].
    pub mass: f64,
    /// Volume over the object's \[1\].
    pub ratio: f64,
    /// Mass of a cell of the solve that made it \[kg\]; zero where it had no grid.
    pub cell: f64,
    /// Whether it was drawn from a law, and not solved.
    pub sampled: bool,
    /// Whether it was divided or joined because the scene asked for it, and not solved.
    pub directed: bool,
}

impl FragmentMass {
    /// Whether it was solved, sampled or directed, as a word.
    #[must_use]
    pub fn made(&self) -> &'static str {
        match (self.sampled, self.directed) {
            (_, true) => FragmentOrigin::Directed,
            (sampled, _) => FragmentOrigin::of_sampled(sampled),
        }
        .word()
    }

    /// Whether it was solved: neither sampled nor directed.
    #[must_use]
    pub fn is_solved(&self) -> bool {
        !self.sampled && !self.directed
    }

    /// Whether a solve made it, of at least so many cells.
    #[must_use]
    pub fn is_resolved(&self, cells: f64) -> bool {
        self.is_solved() && self.mass >= cells * self.cell
    }
}

/// A law fitted by maximum likelihood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Its parameter.
    pub value: f64,
    /// Kolmogorov–Smirnov distance: the greatest gap between the law and the sample \[1\].
    pub distance: f64,
}

/// Both laws, fitted to masses of at least `least`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fits {
    /// How many masses were fitted.
    pub count: usize,
    /// The least mass of the laws \[kg\].
    pub least: f64,
    /// N(>m) = N₀ exp(−√(m/μ)): μ \[kg\].
    pub mott: Fit,
    /// N₀ of that law \[1\].
    pub whole: f64,
    /// n(m) ∝ m^−τ: τ \[1\].
    pub power: Fit,
}

/// Fits both laws to the masses of at least `least` \[kg\]; with `least` zero, to all, from the
/// least of them on. Nothing for fewer than three.
#[must_use]
pub fn fit(masses: &[f64], least: f64) -> Option<Fits> {
    let mut kept: Vec<f64> = masses.iter().copied().filter(|m| *m >= least && *m > 0.0).collect();
    kept.sort_by(f64::total_cmp);
    let least = if least > 0.0 { least } else { *kept.first()? };
    let count = kept.len();
    let n = count as f64;
    // √m − √m₀ is exponential with the mean √μ; ln m/m₀ with the mean 1/(τ − 1).
    let root = kept.iter().map(|m| m.sqrt() - least.sqrt()).sum::<f64>() / n;
    let log = kept.iter().map(|m| libm::log(m / least)).sum::<f64>() / n;
    if count < 3 || root <= 0.0 || log <= 0.0 {
        return None;
    }
    let distance = |below: &dyn Fn(f64) -> f64| {
        let gap = |(k, m): (usize, &f64)| {
            let law = below(*m);
            (law - k as f64 / n).abs().max((law - (k as f64 + 1.0) / n).abs())
        };
        kept.iter().enumerate().map(gap).fold(0.0, f64::max)
    };
    let mott = distance(&|m| 1.0 - libm::exp(-(m.sqrt() - least.sqrt()) / root));
    let power = distance(&|m| 1.0 - libm::pow(m / least, -1.0 / log));
    Some(Fits {
        count,
        least,
        mott: Fit { value: root * root, distance: mott },
        whole: n * libm::exp(least.sqrt() / root),
        power: Fit { value: 1.0 + 1.0 / log, distance: power },
    })
}

/// The fragments of a recording that broke no further, in order of birth.
///
/// # Errors
/// As [`Recording::open`].
pub fn masses(path: &Path) -> Result<Vec<FragmentMass>, RecordError> {
    Ok(of(&Recording::open(path)?))
}

fn of(recording: &Recording) -> Vec<FragmentMass> {
    let broken: BTreeSet<u64> = recording
        .events
        .iter()
        .filter(|event| event.kind() == EventKind::Fractured)
        .filter_map(|event| event.body)
        .collect();
    let spacing = recording.spacings();
    let origins = recording.origins();
    let wholes = recording.bodies.iter().filter(|body| body.parent.is_none());
    let volumes: BTreeMap<&str, f64> = wholes.map(|b| (b.object.as_str(), b.volume)).collect();
    let leaves = recording.bodies.iter().filter(|body| !broken.contains(&body.id));
    leaves
        .filter_map(|body| {
            let h = spacing.get(&body.parent?).copied().unwrap_or(0.0);
            Some(FragmentMass {
                name: body.name.clone(),
                object: body.object.clone(),
                generation: body.generation,
                mass: body.mass,
                ratio: body.volume / volumes.get(body.object.as_str()).copied()?,
                cell: h * h * h * body.mass / body.volume,
                sampled: origins.get(&body.id) == Some(&FragmentOrigin::Sampled),
                directed: origins.get(&body.id) == Some(&FragmentOrigin::Directed),
            })
        })
        .collect()
}

/// The list as CSV, then for each object its fits as lines that begin with `#`, to solved fragments
/// of at least that many cells.
#[must_use]
pub fn table(masses: &[FragmentMass], cells: f64) -> String {
    let mut text = String::from("name,object,generation,mass_kg,volume_ratio,made,resolved\n");
    let mut objects: BTreeMap<&str, Vec<&FragmentMass>> = BTreeMap::new();
    for part in masses {
        let FragmentMass { name, object, generation, mass, ratio, .. } = part;
        let made = part.made();
        let resolved = part.is_resolved(cells);
        let row = [name, object].map(|text| quote_cell(text)).join(",");
        let _never = writeln!(text, "{row},{generation},{mass:e},{ratio:e},{made},{resolved}");
        objects.entry(object).or_default().push(part);
    }
    for (object, parts) in objects {
        let least = cells * parts.iter().map(|part| part.cell).fold(0.0, f64::max);
        let solved = parts.iter().filter(|part| part.is_solved());
        let solved: Vec<f64> = solved.map(|part| part.mass).collect();
        text.push_str(&told(object, (&solved, parts.len()), least));
    }
    text
}

/// `solved`: masses of those that were solved \[kg\], of so many fragments in all.
fn told(object: &str, (solved, all): (&[f64], usize), least: f64) -> String {
    // Such a line is no row, and its name must not begin a cell.
    let object = object.replace([',', ';', '"', '\t', '\n', '\r'], "_");
    let Some(fits) = fit(solved, least) else {
        let solved = solved.len();
        return format!("# {object}: {solved} of {all} fragments solved, too few to fit\n");
    };
    let Fits { count, least, mott, whole, power } = fits;
    format!(
        "# {object}: {count} of {all} fragments were solved and have at least {least:.3e} kg; \
         of samples of a law 95 % have KS below {:.3}\n\
         # {object}: Mott N(>m) = {whole:.1} exp(-sqrt(m/{:.3e} kg)), KS {:.3}\n\
         # {object}: power law n(m) ~ m^-{:.3}, KS {:.3}\n",
        // Kolmogorov's limit for many; with a fitted parameter it is lenient.
        1.36 / (count as f64).sqrt(),
        mott.value,
        mott.distance,
        power.value,
        power.distance
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;
    use cullet_geometry::math::unit;

    fn sample(n: u64, quantile: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..n).map(|k| quantile(unit(8, 2, k))).collect()
    }

    #[test]
    fn motts_law_is_found_in_its_own_sample() {
        let (mu, least) = (3e-4_f64, 1e-4_f64);
        let mott = |u: f64| {
            let root = least.sqrt() - mu.sqrt() * libm::log(1.0 - u);
            root * root
        };
        let mut masses = sample(4000, mott);
        masses.extend([1e-6; 500]);
        let fits = fit(&masses, least).expect("enough");
        assert_eq!(fits.count, 4000, "the crumbs are left out");
        assert!((fits.mott.value / mu - 1.0).abs() < 0.06, "{fits:?}");
        assert!(fits.mott.distance < 0.025 && fits.power.distance > 0.1, "{fits:?}");
        let whole = 4000.0 * libm::exp((least / mu).sqrt());
        assert!((fits.whole / whole - 1.0).abs() < 0.05, "{fits:?}");
    }

    #[test]
    fn a_power_law_is_found_in_its_own_sample() {
        for tau in [1.5, 1.83, 2.4] {
            let masses = sample(4000, |u| 2e-5 * libm::pow(1.0 - u, -1.0 / (tau - 1.0)));
            let fits = fit(&masses, 2e-5).expect("enough");
            assert!((fits.power.value - tau).abs() < 0.05, "{fits:?}");
            assert!(fits.power.distance < 0.025 && fits.mott.distance > 0.05, "{fits:?}");
        }
        assert_eq!(fit(&[1.0, 2.0], 0.0), None);
        assert_eq!(fit(&[1.0; 9], 0.0), None, "equal masses follow neither law");
    }

    #[test]
    fn the_list_holds_what_is_left_of_a_run() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("run.mcap");
        synthetic::run(&path, &synthetic::meta()).expect("records");
        let list = masses(&path).expect("reads");
        let names: Vec<&str> = list.iter().map(|part| part.object.as_str()).collect();
        assert_eq!(names, ["cube", "cube"]);
        assert!(list.iter().all(|part| (part.ratio - 0.5).abs() < 1e-12 && part.cell == 0.0));
        let text = table(&list, RESOLVED_CELLS);
        assert_eq!(text.lines().count(), 4, "{text}");
        assert!(text.ends_with("# cube: 2 of 2 fragments solved, too few to fit\n"), "{text}");
        let drawn = FragmentMass { sampled: true, ..list[0].clone() };
        assert!(list[0].is_resolved(64.0) && !drawn.is_resolved(0.0));
        let drawn = vec![drawn; 9];
        let text = table(&drawn, RESOLVED_CELLS);
        assert!(text.contains(",sampled,false\n"), "{text}");
        assert!(text.ends_with("# cube: 0 of 9 fragments solved, too few to fit\n"), "{text}");
        let bad =
            FragmentMass { name: "=1".to_owned(), object: "a,@b".to_owned(), ..list[0].clone() };
        let text = table(&[bad], RESOLVED_CELLS);
        assert!(text.contains("\n'=1,\"a,@b\",1,") && text.contains("\n# a_@b: "), "{text}");
    }
}
