"""View-dependent colour, chosen by need, goes through the stages."""
import unittest

from stage_case import StageCase
from tiny_dataset import by_direction, uniform

OPTIMIZE = ("--iterations", 400, "--time-limit", 0, "--rays", 1024, "--max-vertices", 1500)
AUTO = ("--sh", "auto", *OPTIMIZE)  # the default


class HarmonicsTest(StageCase):

    def degree(self, field):
        return self.manifest(field)["counts"]["harmonics_degree"]

    def test_a_ball_of_one_colour_ends_without_harmonics(self):
        field = self.folder / "run" / "3_field"
        self.assert_done(self.run_stage("optimize", self.tiny_tetrahedra(paint=uniform), "-o", field, *AUTO))
        self.assertEqual(self.degree(field), 0)

    def test_photos_too_few_for_harmonics_are_logged(self):
        tetrahedra = self.tiny_tetrahedra(paint=by_direction, train=3)
        run = self.run_stage("optimize", tetrahedra, "-o", self.folder / "run" / "3_field", *AUTO)
        self.assert_done(run)
        self.assertIn("harmonics of degree 1 or more are left out: they need 4 training photos", run.stderr)

    def test_a_ball_whose_colour_follows_the_camera_gets_harmonics_that_render(self):
        field, views = self.folder / "run" / "3_field", self.folder / "run" / "4_views"
        tetrahedra = self.tiny_tetrahedra(paint=by_direction)
        self.assert_done(self.run_stage("optimize", tetrahedra, "-o", field, *AUTO))
        self.assertGreaterEqual(self.degree(field), 1)
        with_harmonics = self.manifest(field)["counts"]["watched_psnr"]
        self.assert_done(self.run_stage("render", field, "-o", views))
        plain = self.folder / "plain"
        self.assert_done(self.run_stage("optimize", tetrahedra, "-o", plain, "--sh", 0, *OPTIMIZE))
        # Colours that cannot follow the camera miss them by far.
        self.assertGreater(with_harmonics, self.manifest(plain)["counts"]["watched_psnr"] + 3)


if __name__ == "__main__":
    unittest.main()
