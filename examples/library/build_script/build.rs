fn main() {
    bipedc_compiler::build::robot("../../../robots/tulip");
}
