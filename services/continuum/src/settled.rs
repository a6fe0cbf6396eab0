//! Pieces at rest as rigid bodies of their shape.

use crate::pieces::patience;
use crate::pieces::{GONE, PieceRecord};
use cullet_geometry::midsurface::thicken;
use cullet_geometry::{Solid, TriMesh, Vec3};
use cullet_model::{Figure, Refusal, SettledPiece, TornPiece};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Least volume of a rigid body over that of the box around it \[1\].
const LEAST_FILL: f64 = 1e-9;

/// Most pieces that a window offers as rigid bodies: others wait for the next.
const MOST_SETTLED: usize = 256;

/// How far a corner is drawn back where parts of a wall meet in it alone, over the way to the
/// middle of its part \[1\]: their solids do not touch.
const DRAWN_BACK: f64 = 0.05;

/// Pieces at rest that a window offers as rigid bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SettledOffer {
    /// Their bodies, by number.
    pub settled: Vec<SettledPiece>,
    /// How many cannot be, since their surface bounds no solid.
    pub unfit: usize,
}

impl SettledOffer {
    /// Of pieces at rest: the triangles that each has, by its number, between `places` \[m\], and
    /// the thickness of their walls there \[m\], none where triangles close.
    #[must_use]
    pub fn of(
        pieces: &[TornPiece],
        triangles: &BTreeMap<u32, Vec<[u32; 3]>>,
        places: &[Vec3],
        thickness: &[f64],
    ) -> Self {
        let mut offer = Self::default();
        for piece in pieces {
            if offer.settled.len() == MOST_SETTLED {
                break;
            }
            let own = triangles.get(&piece.number);
            match own.and_then(|own| settled(piece.number, own, places, thickness, piece.mass)) {
                Some(body) => offer.settled.push(body),
                None => offer.unfit += 1,
            }
        }
        offer
    }

    /// Adds to figures and warnings how many pieces cannot be rigid bodies, if any.
    pub fn tell(&self, figures: &mut Vec<Figure>, warnings: &mut Vec<String>) {
        if self.unfit == 0 {
            return;
        }
        let (name, unit) = ("unfit_pieces".to_owned(), "1".to_owned());
        figures.push(Figure { name, unit, value: self.unfit as f64 });
        warnings.push(format!(
            "pieces at rest stay deforming ones, since their walls bound no solid: {}",
            self.unfit
        ));
    }
}

/// Takes pieces out that have become rigid bodies.
///
/// # Errors
/// If one of them is unknown, or not at rest, or has become one before.
pub fn retire(
    pieces: &mut [PieceRecord],
    numbers: &[u32],
    world_step: f64,
    family: &'static str,
) -> Result<(), Refusal> {
    let patience = patience(world_step);
    for number in numbers {
        let rests = |piece: &&mut PieceRecord| {
            piece.number == *number && piece.still >= patience && !piece.is_gone()
        };
        let Some(piece) = pieces.iter_mut().find(rests) else {
            let lack = format!("piece {number} shall be a rigid body, but it is not one at rest");
            return Err(Refusal::Unfit { solver: family, lack });
        };
        piece.still = GONE;
    }
    Ok(())
}

/// The rigid body of a piece: its triangles between places \[m\] of which it may use some, the
/// thickness of its wall at each \[m\] (none where the triangles close), and its mass \[kg\].
/// `None` where they bound no volume, as where the walls of a crumpled sheet cross.
#[must_use]
pub fn settled(
    number: u32,
    triangles: &[[u32; 3]],
    places: &[Vec3],
    thickness: &[f64],
    mass: f64,
) -> Option<SettledPiece> {
    let mut mesh = match thickness.is_empty() {
        true => used(triangles, places).0,
        false => wall_solid(triangles, places, thickness)?,
    };
    let properties = mesh.mass_properties();
    let first = mesh.vertices.first()?;
    let (low, high) = mesh.vertices.iter().fold((*first, *first), |b, x| (b.0.inf(x), b.1.sup(x)));
    let box_volume = (high - low).product();
    let filled = properties.volume > LEAST_FILL * box_volume && properties.volume > 0.0;
    if !filled || !mesh.open_edges().is_empty() {
        return None;
    }
    mesh.vertices.iter_mut().for_each(|v| *v -= properties.centroid);
    let solid = Arc::new(Solid::outer(mesh));
    Some(SettledPiece { number, solid, place: properties.centroid, mass })
}

/// The mesh of some triangles with the vertices that they use, and the number that each had.
fn used(triangles: &[[u32; 3]], places: &[Vec3]) -> (TriMesh, Vec<u32>) {
    let mut renumbered = BTreeMap::new();
    let (mut vertices, mut before) = (Vec::new(), Vec::new());
    let mut own = |v: u32| {
        *renumbered.entry(v).or_insert_with(|| {
            vertices.push(places[v as usize]);
            before.push(v);
            vertices.len() as u32 - 1
        })
    };
    let triangles = triangles.iter().map(|t| t.map(&mut own)).collect();
    (TriMesh { vertices, triangles }, before)
}

/// The closed solid of a wall: one for each part of it that hangs together by edges. `None` where
/// it has none.
fn wall_solid(triangles: &[[u32; 3]], places: &[Vec3], thickness: &[f64]) -> Option<TriMesh> {
    let (triangles, corners) = parted(triangles);
    let mut fans = vec![0; places.len()];
    corners.iter().for_each(|&v| fans[v as usize] += 1);
    let mut moved: Vec<Vec3> = corners.iter().map(|&v| places[v as usize]).collect();
    for (corner, &v) in corners.iter().enumerate().filter(|(_, v)| fans[**v as usize] > 1) {
        let around = triangles.iter().filter(|t| t.contains(&(corner as u32))).flatten();
        let around: Vec<Vec3> = around.map(|&c| places[corners[c as usize] as usize]).collect();
        let middle = around.iter().sum::<Vec3>() / around.len() as f64;
        moved[corner] += (middle - places[v as usize]) * DRAWN_BACK;
    }
    let whole = TriMesh { vertices: moved, triangles };
    let mut solid = TriMesh::default();
    for part in whole.components() {
        let own: Vec<[u32; 3]> = part.iter().map(|&t| whole.triangles[t]).collect();
        let (mesh, before) = used(&own, &whole.vertices);
        let at = |&corner: &u32| thickness[corners[corner as usize] as usize];
        let thickness: Vec<f64> = before.iter().map(at).collect();
        solid.append(&thicken(&mesh.vertices, &mesh.triangles, &thickness).ok()?);
    }
    solid.is_closed().then_some(solid)
}

/// Triangles whose vertices are parted into one for each fan of triangles that share edges there,
/// and the vertex that each was.
fn parted(triangles: &[[u32; 3]]) -> (Vec<[u32; 3]>, Vec<u32>) {
    let mut root: Vec<usize> = (0..3 * triangles.len()).collect();
    let mut sides: BTreeMap<[u32; 2], [usize; 2]> = BTreeMap::new();
    for (t, corners) in triangles.iter().enumerate() {
        for (k, next) in [(0, 1), (1, 2), (2, 0)] {
            let mut ends = [(corners[k], 3 * t + k), (corners[next], 3 * t + next)];
            ends.sort_unstable();
            let [low, high] = ends.map(|(_, slot)| slot);
            let before = *sides.entry(ends.map(|(v, _)| v)).or_insert([low, high]);
            for (a, b) in [(before[0], low), (before[1], high)] {
                let (a, b) = (first_of(&mut root, a), first_of(&mut root, b));
                root[a.max(b)] = a.min(b);
            }
        }
    }
    let (mut numbers, mut before) = (vec![u32::MAX; root.len()], Vec::new());
    let mut of = |slot: usize| {
        let first = first_of(&mut root, slot);
        if numbers[first] == u32::MAX {
            numbers[first] = before.len() as u32;
            before.push(triangles[first / 3][first % 3]);
        }
        numbers[first]
    };
    let renumbered = (0..triangles.len()).map(|t| [0, 1, 2].map(|k| of(3 * t + k))).collect();
    (renumbered, before)
}

/// The first slot that one is the same as.
fn first_of(root: &mut [usize], slot: usize) -> usize {
    let mut at = slot;
    while root[at] != at {
        root[at] = root[root[at]];
        at = root[at];
    }
    at
}

#[cfg(test)]
mod tests {
    use super::{SettledOffer, retire, settled};
    use crate::pieces::patience;
    use crate::pieces::{GONE, PieceRecord, gone_points};
    use cullet_geometry::Vec3;
    use cullet_model::TornPiece;
    use std::collections::BTreeMap;

    #[test]
    fn only_what_is_at_rest_becomes_a_rigid_body_and_only_once() {
        let rests = patience(1e-3);
        let piece = |number, still| PieceRecord { number, still, ..PieceRecord::default() };
        let mut pieces = vec![piece(0, rests), piece(3, rests - 1), piece(1, rests)];
        let refused = |pieces: &mut [PieceRecord], number| {
            retire(pieces, &[number], 1e-3, "family").unwrap_err().to_string()
        };
        assert!(refused(&mut pieces, 2).contains("piece 2"));
        assert!(refused(&mut pieces, 3).contains("not one at rest"));
        retire(&mut pieces, &[1], 1e-3, "family").unwrap();
        assert_eq!(pieces[2].still, GONE);
        assert!(refused(&mut pieces, 1).contains("not one at rest"));
        assert_eq!(gone_points(&[1, 0, 3, 1], &pieces), [true, false, false, true]);
    }

    #[test]
    fn a_sheet_at_rest_is_a_plate_about_its_centre() {
        let places = [
            Vec3::new(9.0, 9.0, 9.0),
            Vec3::new(1.0, 0.0, 2.0),
            Vec3::new(3.0, 0.0, 2.0),
            Vec3::new(3.0, 1.0, 2.0),
            Vec3::new(1.0, 1.0, 2.0),
        ];
        let piece = settled(7, &[[1, 2, 3], [1, 3, 4]], &places, &[0.1; 5], 0.5).unwrap();
        assert_eq!((piece.number, piece.mass), (7, 0.5));
        assert!((piece.place - Vec3::new(2.0, 0.5, 2.0)).norm() < 1e-12, "{}", piece.place);
        let properties = piece.solid.mesh.mass_properties();
        assert!((properties.volume - 0.2).abs() < 1e-12, "{}", properties.volume);
        assert!(properties.centroid.norm() < 1e-12);
        // What is open and has no thickness bounds nothing.
        assert!(settled(7, &[[1, 2, 3], [1, 3, 4]], &places, &[], 0.5).is_none());
    }

    /// Two squares that meet in one corner alone are two plates that do not touch there, and a
    /// third wall at an edge makes that no surface, which is counted.
    #[test]
    fn parts_that_meet_in_a_corner_are_one_body_and_what_bounds_nothing_is_told() {
        let square = |x: f64, y: f64| {
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                .map(|[u, v]| Vec3::new(x + u, y + v, 0.0))
        };
        let mut places = square(0.0, 0.0).to_vec();
        places.extend(&square(1.0, 1.0)[1..]);
        places.push(Vec3::new(0.5, 0.5, 1.0));
        let two = vec![[0, 1, 2], [0, 2, 3], [2, 4, 5], [2, 5, 6]];
        let thickness = vec![0.1; places.len()];
        let piece = settled(1, &two, &places, &thickness, 2.0).unwrap();
        let mesh = &piece.solid.mesh;
        assert!(mesh.is_closed() && mesh.components().len() == 2);
        let volume = mesh.signed_volume();
        assert!((0.19..0.2).contains(&volume), "{volume}");
        let crowded = vec![[0, 1, 2], [0, 2, 3], [0, 2, 7]];
        let torn =
            |number| TornPiece { number, parent: 0, born: 0, mass: 1.0, area: 1.0, frozen: true };
        let own = BTreeMap::from([(1, two), (4, crowded)]);
        let offer = SettledOffer::of(&[1, 2, 4].map(torn), &own, &places, &thickness);
        let numbers: Vec<u32> = offer.settled.iter().map(|piece| piece.number).collect();
        assert_eq!((numbers, offer.unfit), (vec![1], 2));
        let (mut figures, mut warnings) = (Vec::new(), Vec::new());
        offer.tell(&mut figures, &mut warnings);
        assert_eq!((figures[0].name.as_str(), figures[0].value), ("unfit_pieces", 2.0));
        assert_eq!(warnings.len(), 1);
    }
}
