//! Places labels beside their marks without overlap with marks or other labels. Labels without room are left out.

/// Width of a digit and height of a line, in units of the plot.
const TYPE: [f64; 2] = [6.4, 11.0];

/// Half the width of a mark.
const MARK: f64 = 5.0;

/// A rectangle: left, top, right, bottom.
type Box = [f64; 4];

/// Middle of the base line of each label. If labels compete, the first one wins, so that a repeated plot is the same.
pub(in crate::report) fn arrange(marks: &[([f64; 2], &str)], inside: Box) -> Vec<Option<[f64; 2]>> {
    let mut taken: Vec<Box> =
        marks.iter().map(|([x, y], _)| [x - MARK, y - MARK, x + MARK, y + MARK]).collect();
    let place = |([x, y], text): &([f64; 2], &str)| {
        if text.is_empty() {
            return None;
        }
        let (w, h) = (0.5 * TYPE[0] * text.chars().count() as f64, 0.5 * TYPE[1]);
        let (dx, dy) = (MARK + w + 2.0, MARK + h + 1.0);
        let around = [
            (dx, 0.0),
            (0.0, -dy),
            (-dx, 0.0),
            (0.0, dy),
            (dx, -dy),
            (-dx, -dy),
            (dx, dy),
            (-dx, dy),
        ];
        let far = around.map(|(x, y)| (1.8 * x, 1.8 * y));
        let boxes = around.into_iter().chain(far).map(|(dx, dy)| {
            let (cx, cy) = (x + dx, y + dy);
            [cx - w, cy - h, cx + w, cy + h]
        });
        let free = |b: &Box| {
            b[0] >= inside[0]
                && b[1] >= inside[1]
                && b[2] <= inside[2]
                && b[3] <= inside[3]
                && !taken.iter().any(|t| b[0] < t[2] && t[0] < b[2] && b[1] < t[3] && t[1] < b[3])
        };
        let chosen = boxes.into_iter().find(free)?;
        taken.push(chosen);
        Some([0.5 * (chosen[0] + chosen[2]), chosen[3] - 1.5])
    };
    marks.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_overlap() {
        let marks: Vec<([f64; 2], &str)> = (0..12)
            .map(|i| ([100.0 + f64::from(i), 100.0 + 3.0 * f64::from(i % 4)], "12"))
            .collect();
        let placed = arrange(&marks, [0.0, 0.0, 200.0, 200.0]);
        let shown: Vec<[f64; 2]> = placed.iter().flatten().copied().collect();
        assert!(shown.len() > 4);
        for (i, a) in shown.iter().enumerate() {
            for b in &shown[..i] {
                let apart = (a[0] - b[0]).abs() >= 12.7 || (a[1] - b[1]).abs() >= 10.9;
                assert!(apart, "{a:?} on {b:?}");
            }
        }
    }
}
