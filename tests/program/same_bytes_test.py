"""The container's bytes are determined by the input and the options: not by the number of ranks, the build type, or
anything else about the run."""
import filecmp
import os

import check_closed
import meshes
import program

RANKS = (0, 1, 2, 3, 4, 7)  # 0: without mpirun
LEAVES = ("--leaf-triangles", 1500)


class SameBytes(program.ColossusTest):
    def statue(self, *options):
        """Large enough for several parts of 131,072 vertices and faces."""
        path = self.path("statue.ply")
        self.run_program("synth", "-o", path, "--triangles", 280000, "--seed", 3, *options)
        return path

    def assert_same_bytes(self, inputs, options=LEAVES, least_nodes=50, ranks=RANKS):
        reference = self.build("reference.h5", *inputs, options=options)
        self.assertGreaterEqual(self.info(reference)["nodes"], least_nodes)
        for count in ranks:
            other = self.build(f"on_{count}.h5", *inputs, options=options, ranks=count)
            self.assertTrue(filecmp.cmp(reference, other, shallow=False), f"{count} ranks make other bytes than a lone one")
            os.remove(other)
        return reference

    def test_for_any_number_of_ranks_and_build_type(self):
        statue = self.statue()
        other = os.environ.get("COLOSSUS_OTHER_PROGRAM", "")
        # Beside another program this one is slow (sanitizers, Debug): few ranks, and more than there is work for.
        reference = self.assert_same_bytes([statue], ranks=(3, 7) if os.access(other, os.X_OK) else RANKS)
        if not os.access(other, os.X_OK):
            print(f"only the ranks are compared: COLOSSUS_OTHER_PROGRAM={other} is no program of another build type")
            return
        again = self.build("other.h5", statue, options=LEAVES, ranks=2, program=other)
        self.assertTrue(filecmp.cmp(reference, again, shallow=False), f"{other} makes other bytes than {program.PROGRAM}")

    def test_for_blocks(self):
        statue = self.statue()
        options = ("--scheme", "blocks", *LEAVES)
        other = os.environ.get("COLOSSUS_OTHER_PROGRAM", "")
        reference = self.assert_same_bytes([statue], options, ranks=(3, 7) if os.access(other, os.X_OK) else RANKS)
        if os.access(other, os.X_OK):
            again = self.build("other.h5", statue, options=options, ranks=2, program=other)
            self.assertTrue(filecmp.cmp(reference, again, shallow=False), f"{other} makes other bytes than {program.PROGRAM}")

    def test_for_shuffled_input(self):
        self.assert_same_bytes([self.statue("--shuffle", "--normals")], ranks=(3,))

    def test_for_several_files(self):
        """A statue in three files, cut by face number; two of them from a list, in another byte order and as text."""
        whole = check_closed.read_ply(self.statue())
        files = []
        for i in range(3):
            triangles = whole.triangles[i * len(whole.triangles) // 3:(i + 1) * len(whole.triangles) // 3]
            used, index = meshes.np.unique(triangles, return_inverse=True)
            part = check_closed.Mesh(whole.points[used], index.reshape(-1, 3))
            files.append(meshes.write_ply(self.path(f"part_{i}.ply"), part, order="little" if i else "big", text=i == 2))
        with open(self.path("list.txt"), "w", encoding="utf-8") as listing:
            listing.write("part_1.ply\npart_2.ply\n")
        reference = self.assert_same_bytes([files[0], "@" + self.path("list.txt")], ranks=(3, 4))
        counts = self.info(reference)["counts"]
        self.assertEqual(counts["triangles"], len(whole.triangles))
        self.assertEqual(counts["border_edges"], 0, "the files are welded where they meet")

    def test_for_text_read_in_parts(self):
        text = meshes.write_ply(self.path("text.ply"), check_closed.read_ply(self.statue()), text=True)
        self.assert_same_bytes([text], ranks=(2, 3))

    def test_for_more_ranks_than_nodes(self):
        tiny = meshes.write_ply(self.path("tiny.ply"), meshes.tube(12, 8))
        reference = self.assert_same_bytes([tiny], options=(), least_nodes=1, ranks=(1, 7))
        self.assertEqual(self.info(reference)["nodes"], 1)


if __name__ == "__main__":
    program.main()
