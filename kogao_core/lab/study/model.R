# Mixed model of a study: effect of the achieved distance, and of the centre, on "unnatural", with
# random intercepts for raters and faces.
# Run in the folder of answers.csv: Rscript model.R
# Needs lme4: install.packages("lme4") or, on Debian and Ubuntu, apt install r-cran-lme4
library(lme4)

# As text, raters 01 and 1 stay two raters.
answers <- read.csv("answers.csv", colClasses = c(study = "character", rater = "character"))
answers <- subset(answers, counts == 1 & kind == "table1" & !is.na(unnatural))
answers$center <- factor(answers$center)
# Centred, so that the intercept belongs to the mean distance.
answers$distance <- answers$achieved_percent - mean(answers$achieved_percent)

fitted <- function(formula) {
  glmer(formula, data = answers, family = binomial,
        control = glmerControl(optimizer = "bobyqa", optCtrl = list(maxfun = 1e5)))
}
distance <- fitted(unnatural ~ distance + (1 | rater) + (1 | subject))
print(summary(distance))

b <- fixef(distance)
middle <- mean(answers$achieved_percent) - b[["(Intercept)"]] / b[["distance"]]
# Standard error of the middle by the delta method.
slope <- c(-1 / b[["distance"]], b[["(Intercept)"]] / b[["distance"]]^2)
error <- sqrt(as.numeric(t(slope) %*% as.matrix(vcov(distance)) %*% slope))
cat(sprintf("50 %% unnatural at %.2f %% of D (95 %%: %.2f to %.2f)\n",
            middle, middle - 1.96 * error, middle + 1.96 * error))

if (nlevels(answers$center) > 1) {
  centre <- fitted(unnatural ~ distance + center + (1 | rater) + (1 | subject))
  print(summary(centre))
  cat("Do centres differ at the same achieved distance?\n")
  print(anova(distance, centre))
}
