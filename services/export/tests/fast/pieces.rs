//! Pieces at rest make up what broke.

use super::common::{GlbScene, fixture};
use cullet_export::{ExportError, export_pieces};

#[test]
fn pieces_are_files_of_their_own_and_one_of_all() {
    let fixture = fixture();
    let folder = fixture.folder.path().join("pieces");
    let report = export_pieces(&fixture.recording, &folder).expect("pieces");
    let names: Vec<_> = report.files.iter().filter_map(|file| file.file_name()).collect();
    assert_eq!(names, ["cube_2.glb", "cube_3.glb", "pieces.glb", "pieces.csv"]);
    assert_eq!(report.bodies, 2);
    let rest = fixture.recording.rest_poses();
    let all = GlbScene::read(&folder.join("pieces.glb"));
    assert_eq!(all.document.animations().count(), 0);
    for (id, node) in all.bodies() {
        let name = node.name().expect("a name");
        let alone = GlbScene::read(&folder.join(format!("{name}.glb")));
        assert_eq!(alone.bodies().keys().copied().collect::<Vec<_>>(), [id]);
        for (scene, node) in [(&all, &node), (&alone, &alone.bodies()[&id])] {
            let off = super::common::apart(&scene.pose(node, 0.0), &rest[&id]);
            assert!(off < 1e-6 && scene.is_seen(node, 0.0), "{name}: {off}");
        }
    }
    let table = std::fs::read_to_string(folder.join("pieces.csv")).expect("a table");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{table}");
    assert_eq!((rows[1][0], rows[2][0], rows[1][3]), ("cube_2", "cube_3", "1"));
}

#[test]
fn a_run_in_which_nothing_broke_has_no_pieces() {
    let mut fixture = fixture();
    fixture.recording.bodies.truncate(2);
    let folder = fixture.folder.path().join("pieces");
    let refused = export_pieces(&fixture.recording, &folder);
    assert!(matches!(refused, Err(ExportError::NoPieces)), "{refused:?}");
    assert!(!folder.exists());
}
