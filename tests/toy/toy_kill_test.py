"""A toy scheme is killed and goes on like any other, with no line of its own for that."""
import kill_test
import program


class ToyKill(kill_test.Kill):
    def test_sketch(self):
        self.check("sketch", 500)


if __name__ == "__main__":
    program.main()
