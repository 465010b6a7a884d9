//! Products, their shapes and their use in assemblies (ISO 10303-41 and -44).

use super::file::File;
use super::kinds::Kind;
use std::collections::HashMap;

/// A product as a component of another.
pub(super) struct Usage {
    pub id: u32,
    /// The shape definition of the usage, which styles may name.
    pub place: u32,
    pub name: String,
    /// Product definitions.
    pub parent: u32,
    pub child: u32,
}

/// What the file says of products.
#[derive(Default)]
pub(super) struct Products {
    /// By representation: names, and the product definitions' numbers.
    names: HashMap<u32, String>,
    numbers: HashMap<u32, u32>,
    /// Representations by product definition.
    shapes: HashMap<u32, u32>,
    usages: Vec<Usage>,
    /// Indices of usages by the relationship that places them.
    by_relation: HashMap<u32, Vec<usize>>,
}

impl Products {
    pub fn new(file: &File) -> Self {
        let mut products = Self::default();
        let mut usage_by_id = HashMap::new();
        for entity in file.entities() {
            if entity.kind == Kind::NextAssemblyUsageOccurrence {
                let Ok(mut args) = entity.args() else { continue };
                let [number, name] = [args.text(), args.text()];
                let mut args = args.skip(1);
                let Some((parent, child)) = args.optional_reference().zip(args.optional_reference()) else { continue };
                let name = if name.is_empty() { number } else { name };
                usage_by_id.insert(entity.id, products.usages.len());
                products.usages.push(Usage { id: entity.id, place: 0, name, parent, child });
            } else if entity.kind == Kind::ShapeDefinitionRepresentation {
                let Ok(mut args) = entity.args() else { continue };
                let both = args.optional_reference().zip(args.optional_reference());
                let Some((definition, shape)) = both else { continue };
                let Some(product) = definition_of(file, definition) else { continue };
                products.shapes.entry(product).or_insert(shape);
                products.numbers.entry(shape).or_insert(product);
                if let Some(name) = product_name(file, product) {
                    products.names.insert(shape, name);
                }
            }
        }
        for entity in file.entities().filter(|e| e.kind == Kind::ContextDependentShapeRepresentation) {
            let Ok(mut args) = entity.args() else { continue };
            let Some((relation, place)) = args.optional_reference().zip(args.optional_reference()) else { continue };
            let usage = definition_of(file, place).and_then(|usage| usage_by_id.get(&usage).copied());
            if let Some(index) = usage {
                products.usages[index].place = place;
                products.by_relation.entry(relation).or_default().push(index);
            }
        }
        products
    }

    /// The name of the product whose shape this representation is.
    pub fn name(&self, representation: u32) -> Option<&str> {
        self.names.get(&representation).map(String::as_str)
    }

    /// The product definition whose shape this representation is.
    pub fn number(&self, representation: u32) -> Option<u32> {
        self.numbers.get(&representation).copied()
    }

    /// The representation of a product definition's shape.
    pub fn shape(&self, product: u32) -> Option<u32> {
        self.shapes.get(&product).copied()
    }

    pub fn usages(&self) -> impl Iterator<Item = &Usage> {
        self.usages.iter()
    }

    /// The usages that a relationship between representations places.
    pub fn usages_of(&self, relation: u32) -> Vec<&Usage> {
        let indices = self.by_relation.get(&relation).map_or(&[][..], Vec::as_slice);
        indices.iter().map(|&k| &self.usages[k]).collect()
    }
}

/// What a shape definition defines the shape of.
fn definition_of(file: &File, id: u32) -> Option<u32> {
    let args = file.args(id, Kind::ProductDefinitionShape, "the shape of a product").ok()?;
    args.skip(2).optional_reference()
}

/// The name of a product definition's product.
fn product_name(file: &File, id: u32) -> Option<String> {
    let definition = file.get(id).ok()?;
    matches!(definition.kind, Kind::ProductDefinition | Kind::ProductDefinitionWithDocuments).then_some(())?;
    let formation = file.get(definition.args().ok()?.skip(2).optional_reference()?).ok()?;
    let product = formation.args().ok()?.skip(2).optional_reference()?;
    let mut args = file.args(product, Kind::Product, "a product").ok()?;
    let [id, name] = [args.text(), args.text()];
    let name = if name.trim().is_empty() { id } else { name };
    (!name.trim().is_empty()).then_some(name)
}
