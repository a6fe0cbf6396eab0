//! The state of a shell, and what can be read off it.

use super::arrange;
use super::copies::SplitState;
use super::links::Links;
use super::side_pairs::Sides;
use super::tips::CrackTips;
use crate::kernel::{CellSide, PointSetup, Seat, ShellKernel, SurfaceStrain};
use crate::midsurface::Midsurface;
use crate::section::{PointState, SectionLaw, SectionTally};
use cullet_geometry::Vec3;
use cullet_simd::{Real, SimdLevel};

/// Share of the stable step that is taken.
pub const STEP_SHARE: f64 = 0.8;

/// The seat of a point that is off.
const NOWHERE: Seat = usize::MAX;

/// A shell whose cells have `N` functions, worked out in `R`.
#[derive(Clone, Debug)]
pub struct ShellDomain<R: Real, const N: usize> {
    /// Its midsurface before anything moved.
    pub surface: Midsurface,
    /// Its law.
    pub law: SectionLaw,
    /// Mass density ρ \[kg/m³\].
    pub density: f64,
    /// Displacement of each control point \[m\]; the fourth number is nothing.
    pub displacement: Vec<[f64; 4]>,
    /// Velocity of each control point \[m/s\].
    pub velocity: Vec<Vec3>,
    /// Mass of each control point \[kg\].
    pub mass: Vec<f64>,
    /// The control point that each is, or is a copy of.
    pub origin: Vec<u32>,
    /// Force from outside on each control point in the next step \[N\].
    pub external: Vec<Vec3>,
    /// Time step \[s\].
    pub step: f64,
    pub(crate) kernel: ShellKernel<R, N>,
    pub(super) elements: Vec<CellSide<N>>,
    /// What is at each seat.
    pub(super) setup: Vec<PointSetup>,
    pub(super) states: Vec<PointState>,
    /// Where each point is.
    pub(super) seats: Vec<Seat>,
    /// The point at each seat; `u32::MAX` where there is none.
    pub(super) point_at: Vec<u32>,
    pub(super) links: Links,
    pub(super) split: SplitState,
    pub(super) front: CrackTips,
    pub(super) sides: Sides,
}

/// What a shell is made of, beside its midsurface.
#[derive(Clone, Debug)]
pub struct ShellMaterial {
    /// Law of a section.
    pub law: SectionLaw,
    /// Mass density ρ \[kg/m³\].
    pub density: f64,
    /// t of each point \[m\].
    pub thickness: Vec<f64>,
    /// σ_f of each point \[Pa\].
    pub strength: Vec<f64>,
    /// l_c over the extent of a point's cell across the crack \[1\].
    pub softening_cells: f64,
}

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// At rest. The midsurface must have `N` functions a cell.
    #[must_use]
    pub fn new(surface: Midsurface, material: ShellMaterial, level: SimdLevel) -> Self {
        let arranged = arrange::arrange::<N>(&surface);
        let each = surface.points_per_cell();
        let points = surface.points();
        let surfaces: Vec<_> = (0..points).map(|p| surface.surface_point(p)).collect();
        let seats_count = arranged.elements.len() * each;
        let mut point_at = vec![u32::MAX; seats_count];
        let mut seats = vec![NOWHERE; points];
        for (e, &cell) in arranged.cells.iter().enumerate().filter(|(_, cell)| **cell != u32::MAX) {
            for q in 0..each {
                let point = cell as usize * each + q;
                if surface.share[point] > 0.0 {
                    (seats[point], point_at[e * each + q]) = (e * each + q, point as u32);
                }
            }
        }
        let at = |seat: usize| if point_at[seat] == u32::MAX { 0 } else { point_at[seat] as usize };
        let setup: Vec<PointSetup> = (0..seats_count)
            .map(|seat| PointSetup {
                surface: surfaces[at(seat)],
                thickness: material.thickness[at(seat)],
            })
            .collect();
        let states: Vec<PointState> = (0..seats_count)
            .map(|seat| {
                let (p, s) = (at(seat), &surfaces[at(seat)]);
                let spread = s.spread.map(|x| material.softening_cells.powi(2) * x);
                PointState::new(material.strength[p], spread, material.thickness[p], s.area)
            })
            .collect();
        let nodes = surface.nodes.len();
        let kernel = ShellKernel::new(&surface.tables, &arranged.elements, &setup, nodes, level);
        let links = Links::new(&surface, &surfaces);
        let mut domain = Self {
            links,
            front: CrackTips::default(),
            sides: Sides::default(),
            split: SplitState::new::<N>(std::iter::empty(), &[], &[]),
            displacement: vec![[0.0; 4]; nodes],
            velocity: vec![Vec3::zeros(); nodes],
            mass: vec![0.0; nodes],
            origin: (0..nodes as u32).collect(),
            external: vec![Vec3::zeros(); nodes],
            step: 0.0,
            law: material.law,
            density: material.density,
            elements: arranged.elements,
            surface,
            kernel,
            setup,
            states,
            seats,
            point_at,
        };
        domain.weigh();
        let cells = domain.surface.cells.iter();
        let cells = cells.map(|c| std::array::from_fn(|k| c.nodes[k]));
        domain.split = SplitState::new::<N>(cells, &domain.elements, &domain.mass);
        domain.weigh_trimmed();
        domain.step = STEP_SHARE * domain.stable_step();
        (0..domain.states.len()).for_each(|seat| domain.watch(seat));
        domain
    }

    /// The points that are on, ascending.
    pub fn live(&self) -> impl Iterator<Item = usize> + use<R, N> {
        let on: Vec<usize> = (0..self.seats.len()).filter(|&p| self.is_on(p)).collect();
        on.into_iter()
    }

    /// Whether a point is on.
    #[must_use]
    pub fn is_on(&self, point: usize) -> bool {
        self.seats[point] != NOWHERE
    }

    /// Row-summed masses m_a = Σ A_q ρ t R_a.
    fn weigh(&mut self) {
        self.mass.fill(0.0);
        for point in self.live() {
            let setup = &self.setup[self.seats[point]];
            let mass = setup.surface.area * setup.thickness * self.density;
            let element = &self.elements[self.element_of(point)];
            let (_, table) = self.surface.at(point);
            for (k, &node) in element.nodes.iter().enumerate() {
                self.mass[node as usize] += mass * table.value[k];
            }
        }
    }

    pub(super) fn element_of(&self, point: usize) -> usize {
        self.seats[point] / self.surface.points_per_cell()
    }

    /// The stable step of the smallest cell ([`Midsurface::steps`]) \[s\].
    #[must_use]
    pub fn stable_step(&self) -> f64 {
        let speed = (self.law.elastic.modulus / self.density).sqrt();
        let of = |&seat: &Seat| {
            let setup = &self.setup[seat];
            self.surface.steps.step(setup.surface.extent, setup.thickness, speed)
        };
        let on = self.seats.iter().filter(|&&seat| seat != NOWHERE);
        on.map(of).fold(f64::INFINITY, f64::min)
    }

    /// Quadrature points.
    #[must_use]
    pub fn points(&self) -> usize {
        self.seats.len()
    }

    /// Makes all masses so many times as large.
    pub fn scale_mass(&mut self, factor: f64) {
        self.mass.iter_mut().for_each(|mass| *mass *= factor);
        self.density *= factor;
        self.split.scale(factor);
    }

    /// What a point carries.
    #[must_use]
    pub fn state(&self, point: usize) -> &PointState {
        &self.states[self.seats[point]]
    }

    /// The control points of the element that a point belongs to, with their R there.
    #[must_use]
    pub fn functions(&self, point: usize) -> (&[u32; N], &[f64]) {
        let (_, table) = self.surface.at(point);
        (&self.elements[self.element_of(point)].nodes, &table.value[..N])
    }

    /// Changes what a point carries.
    pub fn change(&mut self, point: usize, change: impl FnOnce(&mut PointState)) {
        let seat = self.seats[point];
        change(&mut self.states[seat]);
        self.watch(seat);
    }

    /// Tells the kernel of what is at a seat.
    pub(super) fn watch(&mut self, seat: Seat) {
        let (setup, limit) = match self.point_at[seat] {
            u32::MAX => (None, Some(f64::INFINITY)),
            _ => (Some(&self.setup[seat]), self.law.elastic_limit(&self.states[seat])),
        };
        self.kernel.touch(seat, setup, limit);
    }

    /// A vector of the control points at a point \[unit of theirs\].
    #[must_use]
    pub fn interpolate(&self, point: usize, of: &[Vec3]) -> Vec3 {
        let (nodes, shares) = self.functions(point);
        nodes.iter().zip(shares).map(|(&node, share)| of[node as usize] * *share).sum()
    }

    /// Displacement of a control point \[m\].
    #[must_use]
    pub fn moved(&self, node: usize) -> Vec3 {
        let [x, y, z, _] = self.displacement[node];
        Vec3::new(x, y, z)
    }

    /// Where control points were first, and where they are now \[m\].
    #[must_use]
    pub fn node_places(&self) -> (Vec<Vec3>, Vec<Vec3>) {
        let first = |n: usize| self.surface.nodes[self.origin[n] as usize];
        let all = 0..self.mass.len();
        (all.clone().map(first).collect(), all.map(|n| first(n) + self.moved(n)).collect())
    }

    /// Takes the stresses and damages the points; the forces are then those of
    /// [`ShellDomain::force`].
    pub fn strain(&mut self) -> SectionTally {
        self.kernel.strain(&self.law, &self.displacement, &mut self.states)
    }

    /// Force of the points on a control point \[N\].
    #[must_use]
    pub fn force(&self, node: usize) -> Vec3 {
        Vec3::from(self.kernel.force(node))
    }

    /// Strains of the points that are on, in their order.
    #[must_use]
    pub fn strains(&self) -> Vec<SurfaceStrain> {
        let by_seat = self.kernel.strains(&self.law, &self.displacement, self.states.len());
        self.live().map(|point| by_seat[self.seats[point]]).collect()
    }
}
