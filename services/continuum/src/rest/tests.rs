use super::{POINTS, RestCheck, SPEED};
use crate::pieces::{GONE, PieceRecord, patience};
use cullet_geometry::Vec3;

const STEP: f64 = 1.0 / 240.0;

/// Pieces of six points each, a row of them along x, one every metre.
struct Row {
    labels: Vec<u32>,
    places: Vec<Vec3>,
    velocities: Vec<Vec3>,
    touched: Vec<bool>,
    pieces: Vec<PieceRecord>,
}

impl Row {
    fn new(count: u32) -> Self {
        let labels: Vec<u32> = (0..count).flat_map(|k| [k; POINTS as usize]).collect();
        let place = |(n, &k): (usize, &u32)| {
            Vec3::new(f64::from(k) + 1e-3 * (n % POINTS as usize) as f64, 0.0, 0.0)
        };
        Self {
            places: labels.iter().enumerate().map(place).collect(),
            velocities: vec![Vec3::zeros(); labels.len()],
            touched: vec![true; labels.len()],
            labels,
            pieces: (0..count)
                .map(|number| PieceRecord { number, ..PieceRecord::default() })
                .collect(),
        }
    }

    /// The first of a piece's points.
    fn first(&self, piece: u32) -> usize {
        (piece * POINTS) as usize
    }

    fn count(&mut self, pressed: &[[u32; 2]]) -> bool {
        let held = vec![false; self.labels.len()];
        let check = RestCheck {
            labels: &self.labels,
            places: &self.places,
            velocities: &self.velocities,
            held: &held,
            touched: &self.touched,
            pressed,
            proxies: &[],
            spacing: 1e-3,
            world_step: STEP,
        };
        check.count(&mut self.pieces)
    }

    fn still(&self) -> Vec<u32> {
        self.pieces.iter().map(|piece| piece.still).collect()
    }
}

#[test]
fn what_rests_is_counted_and_what_moves_wakes_its_neighbours() {
    let mut row = Row::new(4);
    assert!(!row.count(&[]));
    assert_eq!(row.still(), [1; 4]);
    // One flies towards the next, and is there within a step of the world.
    let fast = row.first(2);
    row.velocities[fast] = Vec3::new(1.1 / STEP, 0.0, 0.0);
    row.count(&[]);
    assert_eq!(row.still(), [2, 0, 0, 0]);
    row.velocities[fast] = Vec3::new(2.0 * SPEED, 0.0, 0.0);
    row.count(&[]);
    assert_eq!(row.still(), [3, 1, 0, 1]);
}

/// Nothing carries a piece but what touches it: a body, or a piece that is carried itself.
#[test]
fn only_what_is_carried_comes_to_rest() {
    let mut row = Row::new(4);
    for piece in [1, 2, 3] {
        let first = row.first(piece);
        row.touched[first..first + POINTS as usize].fill(false);
    }
    // The second lies on the first; the others press on each other only.
    let pressed = [[0, row.first(1) as u32], [row.first(2) as u32, row.first(3) as u32]];
    for _ in 1..patience(STEP) {
        assert!(!row.count(&pressed));
    }
    assert!(row.count(&pressed), "two are frozen now");
    assert_eq!(row.still(), [patience(STEP), patience(STEP), 0, 0]);
    // What is frozen pushes nothing any more, and goes on resting.
    row.touched.fill(false);
    assert!(!row.count(&[]));
    assert_eq!(row.still(), [patience(STEP), patience(STEP), 0, 0]);
}

/// What has become a rigid body stays away: it is neither counted nor woken, and carries nothing.
#[test]
fn what_is_gone_stays_gone() {
    let mut row = Row::new(3);
    row.pieces[0].still = GONE;
    row.touched.fill(false);
    row.velocities[0] = Vec3::new(1.0, 0.0, 0.0);
    let pressed = [[0, row.first(1) as u32]];
    row.pieces[2].still = patience(STEP);
    row.count(&pressed);
    assert_eq!(row.still(), [GONE, 0, patience(STEP)]);
}
