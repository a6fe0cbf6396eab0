//! How what is left of a body comes to rest: each piece by itself.

use crate::mpm::Domain;
use crate::mpm::crushed::LEAST_POINTS;
use crate::mpm::stencil::Stencil;
use cullet_fragment::kinetic_damping::KineticDamping;
use cullet_geometry::Vec3;

/// The pieces of a body that come to rest.
#[derive(Clone, Debug, Default)]
pub(super) struct PieceSettling {
    pieces: Vec<SettlingPiece>,
    /// Energy that was taken of pieces which have torn since \[J\].
    before: f64,
    /// How many points had torn when pieces were looked for.
    broken: Option<u32>,
}

/// A piece.
#[derive(Clone, Debug)]
struct SettlingPiece {
    /// Its nodes, ascending.
    nodes: Vec<u32>,
    damping: KineticDamping,
    rests: bool,
}

impl PieceSettling {
    /// Energy that was taken \[J\].
    pub(super) fn taken(&self) -> f64 {
        self.before + self.pieces.iter().map(|piece| piece.damping.taken).sum::<f64>()
    }

    /// After a step, lets go of what swings; `broken` points have torn so far. Whether all is at
    /// rest.
    pub(super) fn settle(&mut self, domain: &mut Domain, broken: u32) -> bool {
        if self.broken != Some(broken) {
            self.before = self.taken();
            self.broken = Some(broken);
            self.pieces = pieces(domain);
        }
        let moved = domain.node_displacements();
        let mut velocities = domain.node_velocities();
        for piece in self.pieces.iter_mut().filter(|piece| !piece.rests) {
            let nodes = || piece.nodes.iter().map(|&n| n as usize);
            let masses: Vec<f64> = nodes().map(|n| domain.grid.nodes.mass[n]).collect();
            let places: Vec<Vec3> = nodes().map(|n| domain.grid.place(n) + moved[n]).collect();
            let mut own: Vec<Vec3> = nodes().map(|n| velocities[n]).collect();
            piece.rests = piece.damping.look(&masses, &places, &mut own);
            piece.nodes.iter().zip(own).for_each(|(&n, v)| velocities[n as usize] = v);
        }
        domain.set_node_velocities(&velocities);
        self.pieces.iter().all(|piece| piece.rests)
    }
}

/// The pieces that are resolved. A node goes with the piece that it sees most of.
fn pieces(domain: &Domain) -> Vec<SettlingPiece> {
    let of = domain.pieces();
    let count = of.iter().flatten().max().map_or(0, |&last| last as usize + 1);
    let mut sizes = vec![0; count];
    of.iter().flatten().for_each(|&piece| sizes[piece as usize] += 1);
    let mut seen: Vec<Vec<(u32, f64)>> = vec![Vec::new(); domain.grid.nodes.len()];
    for element in &domain.grid.elements {
        for p in element.points() {
            let Some(piece) = of[domain.particles.id[p] as usize] else { continue };
            let stencil = Stencil::new(&domain.particles.reference[p], &domain.grid.spacing);
            stencil.visit(|k, weight, _| {
                let shares = &mut seen[element.nodes[k] as usize];
                match shares.iter_mut().find(|share| share.0 == piece) {
                    Some(share) => share.1 += weight,
                    None => shares.push((piece, weight)),
                }
            });
        }
    }
    let empty =
        |_| SettlingPiece { nodes: Vec::new(), damping: KineticDamping::default(), rests: false };
    let mut found: Vec<SettlingPiece> = (0..count).map(empty).collect();
    for (node, shares) in seen.iter().enumerate() {
        let most = shares.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        if let Some(&(piece, _)) = most {
            found[piece as usize].nodes.push(node as u32);
        }
    }
    let mut sizes = sizes.into_iter();
    found.retain(|_| sizes.next().is_some_and(|size| size >= LEAST_POINTS));
    found
}
