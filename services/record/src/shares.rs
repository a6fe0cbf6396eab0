//! How much of what a run broke was solved, sampled (drawn from a law) and directed (asked for by
//! the scene).

use cullet_proto::recording::{Body, NewShape, Sampled};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Of the fragments at the end of a run, and of its debris.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shares {
    /// Fragments that are there.
    pub pieces: u64,
    /// Of these, sampled.
    pub sampled_pieces: u64,
    /// Share of the pieces that was sampled; the rest was solved, or directed \[1\].
    pub sampled: f64,
    /// Share of the mass of pieces and grains that was sampled. All grains of debris are: their
    /// sizes are drawn \[1\].
    pub sampled_mass: f64,
    /// Share of that mass that is grains of debris \[1\].
    #[serde(default)]
    pub grain_mass: f64,
    /// Share of the volume that broke, over all fractures, that was sampled \[1\]; nothing where
    /// the recording does not say, as old ones do not.
    #[serde(default)]
    pub sampled_volume: Option<f64>,
    /// The same of the crack area: half of the faces of the sampled fragments, over half of all
    /// \[1\].
    #[serde(default)]
    pub sampled_crack_area: Option<f64>,
    /// What was directed; nothing, and no key, where nothing was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub directed: Option<DirectedShares>,
}

/// Of the fragments at the end of a run, those that were divided or joined because the scene asked
/// for it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DirectedShares {
    /// How many.
    pub pieces: u64,
    /// Share of the pieces \[1\].
    pub share: f64,
    /// The same by mass, debris counted \[1\].
    pub mass: f64,
    /// Share of the volume that broke, over all fractures \[1\].
    pub volume: f64,
    /// The same of the crack area: half of the faces of the directed fragments \[1\].
    pub crack_area: f64,
}

/// The part over the whole, in [0, 1], and never −0, which a sum of nothing is; nothing of nothing.
fn share(part: f64, all: f64) -> f64 {
    if all > 0.0 { (part / all).clamp(0.0, 1.0) + 0.0 } else { 0.0 }
}

impl Shares {
    /// Of so many pieces and so much mass \[kg\], of which so much was sampled.
    #[must_use]
    pub fn of((pieces, sampled_pieces): (u64, u64), (mass, sampled_mass): (f64, f64)) -> Self {
        Self {
            pieces,
            sampled_pieces,
            sampled: share(sampled_pieces as f64, pieces as f64),
            sampled_mass: share(sampled_mass, mass),
            ..Self::default()
        }
    }

    /// A share of the mass of pieces and grains as one of the mass of pieces alone \[1\].
    fn of_pieces(&self, mass: f64) -> f64 {
        share(mass, 1.0 - self.grain_mass)
    }

    /// Share of the mass of the pieces that is in sampled ones; grains are no pieces \[1\].
    #[must_use]
    pub fn sampled_piece_mass(&self) -> f64 {
        self.of_pieces(self.sampled_mass - self.grain_mass)
    }

    /// The same of directed ones \[1\].
    #[must_use]
    pub fn directed_piece_mass(&self) -> f64 {
        self.directed.as_ref().map_or(0.0, |directed| self.of_pieces(directed.mass))
    }

    /// How much was sampled, in words: of the pieces, and of what is no piece.
    #[must_use]
    pub fn tell_sampled(&self) -> String {
        let [pieces, mass, grains] =
            [self.sampled, self.sampled_piece_mass(), self.grain_mass].map(|share| 100.0 * share);
        let grains = match self.grain_mass > 0.0 {
            true => format!("; grains of debris are {grains:.0} % of all mass"),
            false => String::new(),
        };
        format!("{pieces:.0} % of pieces, {mass:.0} % of their mass{grains}")
    }
}

impl fmt::Display for Shares {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let directed = self.directed.as_ref().map_or(0, |directed| directed.pieces);
        let solved = self.pieces - self.sampled_pieces - directed;
        let (all, sampled, told) = (self.pieces, self.sampled_pieces, self.tell_sampled());
        write!(f, "{solved} of {all} pieces solved, {sampled} sampled ({told})")?;
        if let Some(DirectedShares { pieces, share, crack_area, .. }) = &self.directed {
            let [share, mass, area] =
                [*share, self.directed_piece_mass(), *crack_area].map(|share| 100.0 * share);
            write!(
                f,
                ", {pieces} directed ({share:.0} % of pieces, {mass:.0} % of their mass; \
                 {area:.0} % of the crack area)"
            )?;
        }
        match (self.sampled_volume, self.sampled_crack_area) {
            (Some(volume), Some(area)) if self.pieces > 0 => write!(
                f,
                "; of what broke, {:.0} % of the volume and {:.0} % of the crack area were sampled",
                100.0 * volume,
                100.0 * area
            ),
            _ => Ok(()),
        }
    }
}

/// Adds up which fragments there are and which of them were sampled.
#[derive(Clone, Debug, Default)]
pub(super) struct Census {
    /// Mass of each fragment \[kg\].
    masses: BTreeMap<u64, f64>,
    sampled: BTreeSet<u64>,
    directed: BTreeSet<u64>,
    /// Fractures whose fragments are known to be one or the other.
    told: u64,
    /// Those of them whose volumes and crack areas are known, too, and these: solved, sampled,
    /// directed.
    measured: u64,
    /// \[m³\]
    volume: [f64; 3],
    /// \[m²\]
    crack_area: [f64; 3],
}

impl Census {
    pub(super) fn reshaped(&mut self, shape: &NewShape) {
        if let Some(mass) = self.masses.get_mut(&shape.body) {
            *mass = shape.mass;
        }
    }

    pub(super) fn born(&mut self, body: &Body) {
        if body.parent.is_some() {
            self.masses.insert(body.id, body.mass);
        }
    }

    pub(super) fn gone(&mut self, body: u64) {
        self.masses.remove(&body);
    }

    pub(super) fn mark(&mut self, sampled: &Sampled) {
        self.told += 1;
        self.sampled.extend(&sampled.fragments);
        self.directed.extend(&sampled.directed);
        let volume = [sampled.solved_volume, sampled.sampled_volume, sampled.directed_volume];
        let Sampled { solved_crack_area, sampled_crack_area, directed_crack_area, .. } = *sampled;
        let area = [solved_crack_area, sampled_crack_area, directed_crack_area];
        self.measured += u64::from(volume != [0.0; 3]);
        for k in 0..3 {
            self.volume[k] += volume[k];
            self.crack_area[k] += area[k];
        }
    }

    /// The shares; nothing where they are not known of all fractures. `debris`: mass of grains
    /// \[kg\].
    pub(super) fn shares(&self, fractures: u64, debris: f64) -> Option<Shares> {
        if self.told < fractures {
            return None;
        }
        let drawn = || self.masses.iter().filter(|(id, _)| self.sampled.contains(id));
        let pieces = (self.masses.len() as u64, drawn().count() as u64);
        let mass = self.masses.values().sum::<f64>() + debris;
        let sampled = drawn().map(|(_, mass)| mass).sum::<f64>() + debris;
        let measured = self.measured >= fractures;
        let part = |of: [f64; 3], k: usize| share(of[k], of.iter().sum());
        let asked = || self.masses.iter().filter(|(id, _)| self.directed.contains(id));
        let directed = asked().count() as u64;
        Some(Shares {
            sampled_volume: measured.then(|| part(self.volume, 1)),
            sampled_crack_area: measured.then(|| part(self.crack_area, 1)),
            directed: (!self.directed.is_empty()).then(|| DirectedShares {
                pieces: directed,
                share: share(directed as f64, pieces.0 as f64),
                mass: share(asked().map(|(_, mass)| mass).sum(), mass),
                volume: part(self.volume, 2),
                crack_area: part(self.crack_area, 2),
            }),
            grain_mass: share(debris, mass),
            ..Shares::of(pieces, (mass, sampled))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Body, Census, Sampled};

    #[test]
    fn both_shares_are_of_what_is_there_at_the_end() {
        let mut census = Census::default();
        let none = census.shares(0, 0.0).expect("nothing broke");
        assert_eq!((none.pieces, none.sampled_volume), (0, Some(0.0)));
        for (id, mass) in [(0, 9.0), (1, 6.0), (2, 2.0), (3, 1.0)] {
            census.born(&Body { id, parent: (id > 0).then_some(0), mass, ..Body::default() });
        }
        assert_eq!(census.shares(1, 0.0), None, "an old recording does not tell");
        census.mark(&Sampled { body: 0, fragments: vec![2, 3], ..Sampled::default() });
        let shares = census.shares(1, 1.0).expect("it is told");
        assert_eq!((shares.pieces, shares.sampled_pieces), (3, 2));
        assert!((shares.sampled - 2.0 / 3.0).abs() < 1e-12);
        assert!((shares.sampled_mass - 0.4).abs() < 1e-12, "grains of 1 kg are sampled");
        let grains = "; grains of debris are 10 % of all mass)";
        let sampled = "2 sampled (67 % of pieces, 33 % of their mass";
        assert_eq!(shares.to_string(), format!("1 of 3 pieces solved, {sampled}{grains}"));
        census.mark(&Sampled { body: 9, directed: vec![1], ..Sampled::default() });
        let line = format!(
            "0 of 3 pieces solved, {sampled}{grains}, 1 directed (33 % of pieces, 67 % of their \
             mass; 0 % of the crack area)"
        );
        assert_eq!(census.shares(1, 1.0).map(|shares| shares.to_string()), Some(line));
        census.gone(2);
        assert_eq!(census.shares(1, 0.0).map(|shares| shares.pieces), Some(2));
    }

    /// Grains are no pieces: where none was sampled, no mass of pieces was.
    #[test]
    fn a_share_by_number_and_one_by_mass_are_of_the_same_pieces() {
        let mut census = Census::default();
        census.born(&Body { id: 1, parent: Some(0), mass: 5.5, ..Body::default() });
        census.mark(&Sampled { body: 0, ..Sampled::default() });
        let shares = census.shares(1, 4.5).expect("it is told");
        assert_eq!((shares.sampled_mass, shares.sampled_piece_mass()), (0.45, 0.0));
        let line = "1 of 1 pieces solved, 0 sampled (0 % of pieces, 0 % of their mass; grains of \
                    debris are 45 % of all mass)";
        assert_eq!(shares.to_string(), line);
    }
}
