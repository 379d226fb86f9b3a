//! Plots of a study: curves over one varied key, maps over two.

use stiction_draw::figure::{Figure, Line, Panel};
use stiction_draw::heat_map::HeatMap;
use stiction_format::{Key, Setting};

/// Largest number of rows that are drawn.
const MOST_ROWS: u64 = 100_000;

/// Collects the rows of a study whose one or two keys are numbers on a grid, and draws them.
pub struct Pictures {
    keys: Vec<String>,
    objectives: Vec<String>,
    /// Numbers of values by key.
    shape: Vec<usize>,
    /// Numbers of the keys, row by row.
    settings: Vec<Vec<f64>>,
    values: Vec<Vec<Option<f64>>>,
}

/// A picture of a study.
pub(super) enum Picture {
    Curves(Figure),
    Map(HeatMap),
}

impl Pictures {
    /// Pictures of a grid of one or two keys; `None` for other studies.
    pub fn new(keys: &[Key], objectives: &[String], shape: Option<&[u64]>) -> Option<Self> {
        let shape = shape.filter(|shape| matches!(shape.len(), 1 | 2))?;
        let count: u64 = shape.iter().product();
        (count <= MOST_ROWS).then(|| Self {
            keys: keys.iter().map(Key::to_string).collect(),
            objectives: objectives.to_vec(),
            shape: shape.iter().map(|count| *count as usize).collect(),
            settings: Vec::new(),
            values: Vec::new(),
        })
    }

    /// Adds the next row.
    pub fn add(&mut self, settings: &[Setting], values: &[Option<f64>]) {
        let number = |setting: &Setting| match setting {
            Setting::Number(number) => *number,
            Setting::Text(_) => f64::NAN,
        };
        self.settings.push(settings.iter().map(number).collect());
        self.values.push(values.to_vec());
    }

    /// All pictures as SVG, with the names of their files; none if a key has values that are no numbers, or rows
    /// are missing.
    pub fn draw(&self) -> Vec<(String, String)> {
        let svg = |picture: &Picture| match picture {
            Picture::Curves(figure) => figure.svg(),
            Picture::Map(map) => map.svg(),
        };
        self.all().into_iter().map(|(name, picture)| (name, svg(&picture))).collect()
    }

    /// All pictures with the names of their files.
    pub(super) fn all(&self) -> Vec<(String, Picture)> {
        let is_numeric = self.settings.iter().flatten().all(|number| number.is_finite());
        if !is_numeric || self.values.len() != self.shape.iter().product::<usize>() {
            return Vec::new();
        }
        match self.shape.as_slice() {
            [_] => vec![("sweep.svg".to_owned(), Picture::Curves(self.curves()))],
            [rows, columns] => (0..self.objectives.len())
                .map(|k| {
                    let name = match self.objectives.len() {
                        1 => "sweep.svg".to_owned(),
                        _ => format!("sweep-{}.svg", k + 1),
                    };
                    (name, Picture::Map(self.map(k, *rows, *columns)))
                })
                .collect(),
            _ => Vec::new(),
        }
    }

    fn curves(&self) -> Figure {
        let panel = |(k, objective): (usize, &String)| {
            let points = self.settings.iter().zip(&self.values);
            let points = points.filter_map(|(x, values)| Some((x[0], values[k]?))).collect();
            let line = Line { label: String::new(), points, colour: k, dashed: false };
            Panel { y_label: objective.clone(), lines: vec![line], bands: Vec::new() }
        };
        Figure {
            title: format!("Over {}", self.keys[0]),
            x_label: self.keys[0].clone(),
            panels: self.objectives.iter().enumerate().map(panel).collect(),
        }
    }

    fn map(&self, objective: usize, rows: usize, columns: usize) -> HeatMap {
        let row = |row: usize| {
            (0..columns).map(|column| self.values[row * columns + column][objective]).collect()
        };
        HeatMap {
            title: self.objectives[objective].clone(),
            x_label: self.keys[1].clone(),
            y_label: self.keys[0].clone(),
            x: (0..columns).map(|column| self.settings[column][1]).collect(),
            y: (0..rows).map(|row| self.settings[row * columns][0]).collect(),
            values: (0..rows).map(row).collect(),
        }
    }
}
