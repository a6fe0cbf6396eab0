//! The graph of points: which are joined, and which links cracks have severed.

use crate::midsurface::{Midsurface, MidsurfacePoint};
use cullet_continuum::bytes::held;
use cullet_geometry::Vec3;

/// A link is severed where it runs within 60° of the crack's normal.
const ACROSS: f64 = 0.5;

/// Two broken points are of one chain where the line between them runs within this of along it:
/// |d·n̂| over |d|.
const ABREAST: f64 = 0.85;

/// Points of a part below which it is none of its own: it goes with its neighbours (F99).
pub(super) const LEAST_PART: usize = 4;

/// Points, their links, and the side that each broken one faces.
#[derive(Clone, Debug)]
pub(super) struct Links {
    /// By entry of the midsurface's list of neighbours.
    pub(super) severed: Vec<bool>,
    /// Unit normal of the crack of each broken point, turned like those beside it; zero before.
    pub(super) facing: Vec<Vec3>,
    /// The same of the second crack of each point that has one.
    pub(super) second: Vec<Vec3>,
    /// Where each point is \[m\], and its frame.
    places: Vec<Vec3>,
    frames: Vec<[Vec3; 2]>,
    /// Points that bear nothing at all.
    pub(super) dead: Vec<bool>,
}

impl Links {
    pub(super) fn new(surface: &Midsurface, points: &[MidsurfacePoint]) -> Self {
        let mut links = Self {
            severed: vec![false; surface.neighbours.len()],
            facing: vec![Vec3::zeros(); points.len()],
            second: vec![Vec3::zeros(); points.len()],
            places: points.iter().map(|p| p.place).collect(),
            frames: points.iter().map(MidsurfacePoint::frame).collect(),
            dead: vec![false; points.len()],
        };
        for point in (0..points.len()).filter(|&p| surface.share[p] == 0.0) {
            links.kill(surface, point);
        }
        links
    }

    /// Memory that it takes \[bytes\].
    pub(super) fn bytes(&self) -> u64 {
        let vectors = [&self.facing, &self.second, &self.places].map(|list| held(list));
        let flags = held(&self.severed) + held(&self.dead);
        vectors.iter().sum::<u64>() + held(&self.frames) + flags
    }

    /// Normal of a broken point's crack, in space.
    pub(super) fn facing(&self, point: usize) -> Vec3 {
        self.facing[point]
    }

    /// The same of its second crack.
    pub(super) fn second(&self, point: usize) -> Vec3 {
        self.second[point]
    }

    pub(super) fn place(&self, point: usize) -> Vec3 {
        self.places[point]
    }

    /// Whether the link of that entry is whole.
    pub(super) fn is_whole(&self, entry: usize) -> bool {
        !self.severed[entry]
    }

    /// The normal of a point's cracks that is most along `direction`; zero if it has none.
    fn alike(&self, point: usize, direction: &Vec3) -> Vec3 {
        let [first, second] = [self.facing[point], self.second[point]];
        let further = second.dot(direction).abs() > first.dot(direction).abs();
        if further { second } else { first }
    }

    /// Severs the links on one side of a point that has broken across `normal` (in its frame), for
    /// the second time if it has a crack; the neighbours on that side. The side is the one that the
    /// broken ones beside it have parted on, so that a chain of them severs one row.
    pub(super) fn break_point(
        &mut self,
        surface: &Midsurface,
        point: usize,
        normal: [f64; 2],
    ) -> Vec<u32> {
        let [e1, e2] = self.frames[point];
        let mut facing = e1 * normal[0] + e2 * normal[1];
        let beside = surface.around(point).iter().map(|&q| self.alike(q as usize, &facing));
        if beside.map(|other| other.dot(&facing)).sum::<f64>() < 0.0 {
            facing = -facing;
        }
        let is_first = self.facing[point].norm_squared() == 0.0;
        *(if is_first { &mut self.facing[point] } else { &mut self.second[point] }) = facing;
        let mut parted = Vec::new();
        for (k, &other) in surface.around(point).iter().enumerate() {
            let along = self.places[other as usize] - self.places[point];
            let across = along.dot(&facing) / along.norm();
            let is_gone = self.dead[other as usize];
            if across >= ACROSS && !is_gone && !self.is_chain(point, &facing, other as usize) {
                self.sever(surface, surface.starts[point] as usize + k, point);
                parted.push(other);
            }
        }
        self.close_jogs(surface, point, &facing, &parted);
        parted
    }

    /// Whether two broken points belong to one chain: they part on the same side, and neither lies
    /// straight over the other. `own` is the normal of the first one's crack.
    fn is_chain(&self, point: usize, own: &Vec3, other: usize) -> bool {
        let along = self.places[other] - self.places[point];
        let is_abreast = along.dot(own).abs() <= ABREAST * along.norm();
        self.alike(other, own).dot(own) > 0.0 && is_abreast
    }

    /// Where a chain steps from one row of points to the next, a link along the row would join its
    /// two sides: severs those between a point of the chain and what the one beside it has parted
    /// from, and those that cross the line between the two.
    fn close_jogs(&mut self, surface: &Midsurface, point: usize, own: &Vec3, parted: &[u32]) {
        let beside = surface.around(point).iter().copied();
        let chain: Vec<u32> = beside.filter(|&p| self.is_chain(point, own, p as usize)).collect();
        for p in chain {
            let off: Vec<u32> = self.parted_from(surface, p as usize, own);
            for q in off {
                self.sever_between(surface, point, q, own);
            }
            for &q in parted {
                self.sever_between(surface, p as usize, q, own);
            }
            self.sever_crossing(surface, point, p as usize);
        }
    }

    /// Severs the links that cross the one between two neighbours.
    fn sever_crossing(&mut self, surface: &Midsurface, one: usize, two: usize) {
        let line = self.places[two] - self.places[one];
        let up = self.frames[one][0].cross(&self.frames[one][1]);
        let across = up.cross(&line).normalize();
        let least = 0.1 * line.norm();
        let side = |&p: &u32| (self.places[p as usize] - self.places[one]).dot(&across);
        let near = |p: &u32| surface.around(two).binary_search(p).is_ok();
        let both = || surface.around(one).iter().copied().filter(near);
        let left: Vec<u32> = both().filter(|p| side(p) > least).collect();
        let right: Vec<u32> = both().filter(|p| side(p) < -least).collect();
        for p in left.into_iter().map(|p| p as usize) {
            for q in &right {
                if let Ok(k) = surface.around(p).binary_search(q) {
                    self.sever(surface, surface.starts[p] as usize + k, p);
                }
            }
        }
    }

    /// What a broken point has parted from on the side that its crack along `own` faces.
    fn parted_from(&self, surface: &Midsurface, point: usize, own: &Vec3) -> Vec<u32> {
        let facing = self.alike(point, own);
        let around = surface.around(point).iter().enumerate();
        let off = around.filter(|&(k, &q)| {
            let along = self.places[q as usize] - self.places[point];
            let entry = surface.starts[point] as usize + k;
            self.severed[entry] && along.dot(&facing) >= ACROSS * along.norm()
        });
        off.map(|(_, &q)| q).collect()
    }

    /// Severs the link of a broken point with one that is whole across `own`, if there is one.
    fn sever_between(&mut self, surface: &Midsurface, point: usize, whole: u32, own: &Vec3) {
        let is_broken = self.alike(whole as usize, own).dot(own).abs() >= ACROSS;
        let found = surface.around(point).binary_search(&whole);
        if let (false, Ok(k)) = (is_broken, found) {
            self.sever(surface, surface.starts[point] as usize + k, point);
        }
    }

    /// Severs the link of that entry of `point`, before anything has moved.
    pub(super) fn cut(&mut self, surface: &Midsurface, entry: usize, point: usize) {
        self.sever(surface, entry, point);
    }

    /// Severs all links of a point that bears nothing any more; whether it had not done so.
    pub(super) fn kill(&mut self, surface: &Midsurface, point: usize) -> bool {
        if std::mem::replace(&mut self.dead[point], true) {
            return false;
        }
        let range = surface.starts[point] as usize..surface.starts[point + 1] as usize;
        for entry in range {
            self.sever(surface, entry, point);
        }
        true
    }

    /// Severs a link of `point` in both lists; whether it was whole.
    fn sever(&mut self, surface: &Midsurface, entry: usize, point: usize) -> bool {
        let other = surface.neighbours[entry] as usize;
        let was_whole = !std::mem::replace(&mut self.severed[entry], true);
        if let Ok(back) = surface.around(other).binary_search(&(point as u32)) {
            self.severed[surface.starts[other] as usize + back] = true;
        }
        was_whole
    }

    /// The part that a point belongs to, up to [`LEAST_PART`] points: whether it has that many.
    pub(super) fn is_part(&self, surface: &Midsurface, point: u32) -> bool {
        let mut found = vec![point];
        let mut next = 0;
        while next < found.len() && found.len() < LEAST_PART {
            let p = found[next] as usize;
            next += 1;
            for (k, &q) in surface.around(p).iter().enumerate() {
                let entry = surface.starts[p] as usize + k;
                if self.is_whole(entry) && !found.contains(&q) {
                    found.push(q);
                }
            }
        }
        found.len() >= LEAST_PART
    }

    /// Components of `points` (ascending) by whole links among them. Points of parts that are too
    /// small, and dead ones, go with the first neighbour that is of a part.
    pub(super) fn components(&self, surface: &Midsurface, points: &[u32]) -> Vec<Vec<u32>> {
        let small: Vec<bool> = points.iter().map(|&p| !self.is_part(surface, p)).collect();
        let mut labels = PointLabels { links: self, surface, points, of: Vec::new(), count: 0 };
        labels.of = vec![usize::MAX; points.len()];
        labels.flood(|at| !small[at]);
        // Rings of points without a part take their label inward from their neighbours.
        labels.spread(|_| true, false);
        let PointLabels { of: label, count, .. } = labels;
        let mut parts = vec![Vec::new(); count.max(1)];
        for (at, &p) in points.iter().enumerate() {
            parts[if label[at] == usize::MAX { 0 } else { label[at] }].push(p);
        }
        parts.retain(|part| !part.is_empty());
        parts
    }
}

/// Labels of some points, ascending.
struct PointLabels<'a> {
    links: &'a Links,
    surface: &'a Midsurface,
    points: &'a [u32],
    /// Label of each; the greatest number where it has none.
    of: Vec<usize>,
    count: usize,
}

impl PointLabels<'_> {
    /// The neighbours of a point among the points, and whether they are joined.
    fn around(&self, at: usize) -> impl Iterator<Item = (usize, bool)> + '_ {
        let p = self.points[at] as usize;
        let first = self.surface.starts[p] as usize;
        let all = self.surface.around(p).iter().enumerate();
        all.filter_map(move |(k, q)| {
            let next = self.points.binary_search(q).ok()?;
            Some((next, self.links.is_whole(first + k)))
        })
    }

    /// Gives each set of `some` points that are joined and have no label one of its own.
    fn flood(&mut self, some: impl Fn(usize) -> bool) {
        for start in 0..self.points.len() {
            if self.of[start] != usize::MAX || !some(start) {
                continue;
            }
            self.of[start] = self.count;
            let mut stack = vec![start];
            while let Some(at) = stack.pop() {
                let joined: Vec<usize> =
                    self.around(at).filter(|next| next.1).map(|next| next.0).collect();
                for next in joined {
                    if self.of[next] == usize::MAX && some(next) {
                        self.of[next] = self.count;
                        stack.push(next);
                    }
                }
            }
            self.count += 1;
        }
    }

    /// Gives `some` points without a label the least of their neighbours', or of those that they
    /// are joined to, ring by ring.
    fn spread(&mut self, some: impl Fn(usize) -> bool, joined: bool) {
        loop {
            let found: Vec<(usize, usize)> = (0..self.points.len())
                .filter(|&at| self.of[at] == usize::MAX && some(at))
                .filter_map(|at| {
                    let near = self.around(at).filter(|next| next.1 || !joined);
                    let labels = near.map(|next| self.of[next.0]);
                    labels.filter(|&l| l != usize::MAX).min().map(|l| (at, l))
                })
                .collect();
            if found.is_empty() {
                break;
            }
            found.into_iter().for_each(|(at, l)| self.of[at] = l);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Links;
    use crate::midsurface::Midsurface;
    use cullet_geometry::nurbs::NurbsPatch;

    /// Two rows of broken points part a sheet in three; a second crack that crosses them, and steps
    /// sideways on its way, parts each of these in two.
    #[test]
    fn a_second_crack_parts_what_a_first_has_left() {
        let patch = NurbsPatch::sheet([1.0, 1.0], [8, 8], 2).unwrap();
        let surface = Midsurface::of_patch(&patch);
        let points: Vec<_> = (0..surface.points()).map(|p| surface.surface_point(p)).collect();
        let all: Vec<u32> = (0..points.len() as u32).collect();
        let mut links = Links::new(&surface, &points);
        let parts = |links: &Links| links.components(&surface, &all).len();
        assert_eq!(parts(&links), 1);
        // Rows and columns of points, counted from one side.
        let number = |x: f64| ((x + 0.5) * 16.0) as usize;
        let row = |p: usize| number(points[p].place.y);
        let column = |p: usize| number(points[p].place.x);
        let first: Vec<usize> = (0..points.len()).filter(|&p| [5, 10].contains(&row(p))).collect();
        first.iter().for_each(|&p| drop(links.break_point(&surface, p, [0.0, 1.0])));
        assert_eq!((first.len(), parts(&links)), (32, 3));
        // One column below the row and the next above it.
        let of = |p: usize| column(p) == if row(p) < 7 { 6 } else { 7 };
        let second: Vec<usize> = (0..points.len()).filter(|&p| of(p)).collect();
        second.iter().for_each(|&p| drop(links.break_point(&surface, p, [1.0, 0.0])));
        assert_eq!((second.len(), parts(&links)), (16, 6));
    }
}
