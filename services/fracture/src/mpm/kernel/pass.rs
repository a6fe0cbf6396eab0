//! The points' pass over all blocks, in either precision and on any path of the processor.

use super::block::{Block, Four, Scratch};
use super::law::PointLaw;
use crate::mpm::grid::{BackgroundGrid, GridElement};
use crate::mpm::tally::DomainTally;
use crate::particles::Particles;
use cullet_model::PointPrecision;
use cullet_simd::{Incidence, Real, SimdLevel};
use fearless_simd::dispatch;
use rayon::prelude::*;
use wide::f64x4;

/// Elements of a block at the start: about 500 points, so that a block fits the first cache, shares
/// most of its nodes, and fills four tiles.
const ELEMENTS: usize = 64;

/// Mass of a node, over the heaviest's, below which it is pushed as if it had that \[1\].
///
/// The forces of an element are rounded as its heaviest node's are: on a node that hardly sees
/// a point what is left of f32 is noise, and noise over its mass runs away, until its
/// displacement is more than f32 can tell the strain of its neighbours from (F04).
pub(crate) fn least_share(precision: PointPrecision) -> f64 {
    match precision {
        PointPrecision::Single => 1e-7,
        PointPrecision::Double => 0.0,
    }
}

/// The blocks of a body in one precision.
#[derive(Clone, Debug)]
struct Pass<R> {
    blocks: Vec<Block<R>>,
    /// First point of each block, then the number of points.
    starts: Vec<u32>,
    /// Forces \[N\] on the nodes of each block in turn.
    forces: Vec<Four<R>>,
    /// For each node its places in `forces`.
    rows: Incidence,
}

impl<R: Real> Pass<R> {
    fn new(grid: &BackgroundGrid, particles: &Particles) -> Self {
        let starts = grid.elements.iter().step_by(ELEMENTS).map(|e| e.first);
        let starts = starts.chain([particles.len() as u32]).collect();
        let (blocks, forces, rows) = (Vec::new(), Vec::new(), Incidence::default());
        let mut pass = Self { blocks, starts, forces, rows };
        pass.refresh(grid, particles, None);
        pass
    }

    /// Makes anew the blocks of the elements that begin at the points `changed`, ascending, or all
    /// of them. Points must have stayed in their block.
    fn refresh(&mut self, grid: &BackgroundGrid, particles: &Particles, changed: Option<&[u32]>) {
        let mut old = std::mem::take(&mut self.blocks).into_iter();
        let (mut rest, mut work) = (grid.elements.as_slice(), Vec::new());
        for pair in self.starts.windows(2) {
            let (own, after) = rest.split_at(rest.partition_point(|e| e.first < pair[1]));
            rest = after;
            let is_new = changed.is_none_or(|changed| {
                let next = changed.partition_point(|&first| first < pair[0]);
                changed.get(next).is_some_and(|&first| first < pair[1])
            });
            work.push((own, old.next().filter(|_| !is_new)));
        }
        let make = |places: &mut Vec<u16>, (own, old): (&[GridElement], Option<Block<R>>)| {
            old.unwrap_or_else(|| Block::new(own, particles, &grid.spacing, places))
        };
        let places = || vec![0; grid.nodes.len()];
        self.blocks = work.into_par_iter().map_init(places, make).collect();
        let ids = self.blocks.iter().flat_map(|block| block.nodes.iter().copied());
        self.rows = Incidence::new(ids, grid.nodes.len());
        self.forces.resize(self.rows.entries.len(), [R::of(0.0); 4]);
    }

    /// Takes the state of point `p` anew.
    fn touch(&mut self, p: u32) {
        let after = self.starts.partition_point(|&start| start <= p);
        self.blocks[after - 1].stale = true;
    }

    fn strain(
        &mut self,
        law: &PointLaw<'_>,
        grid: &BackgroundGrid,
        particles: &mut Particles,
        simd_level: SimdLevel,
    ) -> DomainTally {
        let mut rest = self.forces.as_mut_slice();
        let mut views = particles.views(&self.starts);
        let mut work: Vec<_> = self
            .blocks
            .iter_mut()
            .zip(&mut views)
            .map(|(block, view)| {
                let (forces, after) = std::mem::take(&mut rest).split_at_mut(block.nodes.len());
                rest = after;
                (block, view, forces)
            })
            .collect();
        let (nodes, level) = (&grid.nodes, simd_level.level());
        let tallies: Vec<DomainTally> = work
            .par_iter_mut()
            .map_init(Scratch::new, |scratch, (block, view, forces)| {
                dispatch!(level, simd => block.strain(simd, law, nodes, view, forces, scratch))
            })
            .collect();
        tallies.into_iter().fold(DomainTally::default(), DomainTally::add)
    }

    /// Sum of the forces on a node \[N\].
    #[inline]
    fn force(&self, node: usize) -> f64x4 {
        let mut sum = f64x4::splat(0.0);
        for &row in self.rows.of(node) {
            sum += f64x4::new(self.forces[row as usize].map(R::wide));
        }
        sum
    }
}

#[derive(Clone, Debug)]
enum Either {
    Single(Pass<f32>),
    Double(Pass<f64>),
}

/// Strain, stress, damage and forces of all points.
#[derive(Clone, Debug)]
pub(crate) struct Kernel {
    pass: Either,
    simd_level: SimdLevel,
}

impl Kernel {
    pub(crate) fn new(
        grid: &BackgroundGrid,
        particles: &Particles,
        as_is: PointPrecision,
        simd_level: SimdLevel,
    ) -> Self {
        let pass = match as_is {
            PointPrecision::Single => Either::Single(Pass::new(grid, particles)),
            PointPrecision::Double => Either::Double(Pass::new(grid, particles)),
        };
        Self { pass, simd_level }
    }

    /// After the elements that began at the points `changed` have; points may only have moved
    /// within their cell.
    pub(crate) fn refresh(
        &mut self,
        grid: &BackgroundGrid,
        particles: &Particles,
        changed: &[u32],
    ) {
        match &mut self.pass {
            Either::Single(pass) => pass.refresh(grid, particles, Some(changed)),
            Either::Double(pass) => pass.refresh(grid, particles, Some(changed)),
        }
    }

    /// After the strength of a point has changed, or when a crack may come near it.
    pub(crate) fn touch(&mut self, p: u32) {
        match &mut self.pass {
            Either::Single(pass) => pass.touch(p),
            Either::Double(pass) => pass.touch(p),
        }
    }

    /// Damages the points and takes the forces.
    pub(crate) fn strain(
        &mut self,
        law: &PointLaw<'_>,
        grid: &BackgroundGrid,
        particles: &mut Particles,
    ) -> DomainTally {
        match &mut self.pass {
            Either::Single(pass) => pass.strain(law, grid, particles, self.simd_level),
            Either::Double(pass) => pass.strain(law, grid, particles, self.simd_level),
        }
    }

    /// Sum of the forces on a node \[N\].
    #[inline]
    pub(crate) fn force(&self, node: usize) -> f64x4 {
        match &self.pass {
            Either::Single(pass) => pass.force(node),
            Either::Double(pass) => pass.force(node),
        }
    }
}
