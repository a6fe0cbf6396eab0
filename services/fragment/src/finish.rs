//! From the parts of a cut to fragments that move, hairlines, and debris.

use crate::cut::{CutPart, slit};
use crate::debris::{self, Motes};
use crate::motion;
use cullet_geometry::Vec3;
use cullet_model::{BrittleProblem, Fragment, Grain};

/// Velocity of a part's centroid \[m/s\] and its angular velocity \[rad/s\].
pub type FragmentMotion = (Vec3, Vec3);

/// What the parts of a cut are finished with.
#[derive(Clone, Copy, Debug)]
pub struct Finish<'a> {
    /// What was solved.
    pub problem: &'a BrittleProblem,
    /// Least and greatest distance of points of the solve, across and in the plane \[m\].
    pub spacing: (f64, f64),
    /// Points of the solve that broke.
    pub motes: &'a Motes,
    /// Where something pushed \[m\], and what it gave \[N·s\].
    pub pushes: &'a [(Vec3, Vec3)],
}

/// What becomes of the parts.
#[derive(Clone, Debug, Default)]
pub struct FinishedParts {
    /// By falling volume.
    pub fragments: Vec<Fragment>,
    /// Parts too small to be fragments, and what slits took.
    pub debris: Vec<Grain>,
    /// What was noticed and let pass, a sentence each.
    pub warnings: Vec<String>,
}

impl Finish<'_> {
    /// The fragments: together they carry what was given to the body.
    #[must_use]
    pub fn fragments(&self, parts: Vec<CutPart>, motions: &[FragmentMotion]) -> FinishedParts {
        let density = self.problem.material.density;
        let balance = |fragments: &mut [Fragment]| motion::balance(fragments, self.pushes, density);
        self.finished((parts, motions, &[]), balance)
    }

    /// The fragments of parts that together carry a momentum \[kg·m/s\] and an angular momentum
    /// about their common centre \[kg·m²/s\]. Parts that have `crumbled` become debris, whatever
    /// their size.
    #[must_use]
    pub fn carrying(
        &self,
        parts: Vec<CutPart>,
        motions: &[FragmentMotion],
        crumbled: &[bool],
        [momentum, about]: [Vec3; 2],
    ) -> FinishedParts {
        let density = self.problem.material.density;
        let carry =
            |fragments: &mut [Fragment]| motion::carry(fragments, momentum, |_| about, density);
        self.finished((parts, motions, crumbled), carry)
    }

    fn finished(
        &self,
        (parts, motions, crumbled): (Vec<CutPart>, &[FragmentMotion], &[bool]),
        balance: impl FnOnce(&mut [Fragment]),
    ) -> FinishedParts {
        let (mut fragments, mut cracks) = (Vec::new(), Vec::new());
        for (part, &(velocity, spin)) in parts.into_iter().zip(motions) {
            let sheet = slit::joined(&part.cracks);
            fragments.push(Fragment {
                solid: part.solid,
                hulls: part.hulls,
                velocity,
                spin,
                sheet,
            });
            cracks.push(part.cracks);
        }
        balance(&mut fragments);
        let debris = self.crumble(&mut fragments, crumbled);
        // Each fragment keeps the cracks that are its own.
        let mut gone = crumbled.iter().chain(std::iter::repeat(&false));
        cracks.retain(|_| gone.next().is_some_and(|gone| !*gone));
        let mut finished = FinishedParts { debris, ..FinishedParts::default() };
        if let Some(width) = self.problem.settings.brittle.hairline {
            let (grain, seed, motes) = (self.grain(), self.problem.seed, self.motes);
            let terms = slit::SlitTerms { width, spacing: self.spacing.0, grain, seed, motes };
            let (dust, warnings) = slit::hairlines(&mut fragments, &cracks, &terms);
            finished.debris.extend(dust);
            finished.warnings = warnings;
        }
        finished.fragments = fragments;
        finished
    }

    /// Takes the smallest fragments out, and those that have crumbled, as debris. The two largest
    /// others stay whatever their size.
    fn crumble(&self, fragments: &mut Vec<Fragment>, crumbled: &[bool]) -> Vec<Grain> {
        let settings = &self.problem.settings;
        let least = settings.debris * self.problem.solid.mesh.signed_volume();
        let mut gone = crumbled.iter().chain(std::iter::repeat(&false));
        let parts = std::mem::take(fragments).into_iter();
        let (mut small, whole): (Vec<Fragment>, Vec<Fragment>) =
            parts.partition(|_| gone.next().is_some_and(|gone| *gone));
        *fragments = whole;
        // They come by falling volume.
        let large = fragments.partition_point(|f| f.solid.mesh.signed_volume() >= least).max(2);
        let mut tiny = fragments.split_off(large.min(fragments.len()));
        small.append(&mut tiny);
        small
            .iter()
            .enumerate()
            .flat_map(|(i, f)| {
                let (mesh, motes) = (&f.solid.mesh, self.motes.around(&f.solid.mesh));
                let (velocity, spin) = (f.velocity, f.spin);
                let part = debris::CrumblingPart { mesh, velocity, spin, motes: &motes };
                let seed = self.problem.seed.wrapping_add(i as u64);
                debris::grains(&part, self.grain(), seed).grains
            })
            .collect()
    }

    /// Median size of debris \[m\].
    fn grain(&self) -> f64 {
        self.problem.settings.grain.unwrap_or(0.5 * self.spacing.1)
    }
}
